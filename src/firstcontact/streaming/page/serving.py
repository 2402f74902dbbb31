"""Functions that web pages share: access control, static files, and response headers."""

from __future__ import annotations

import hmac
import ipaddress
import logging
import socket
from collections.abc import Awaitable, Callable, Mapping
from contextlib import AbstractAsyncContextManager
from dataclasses import dataclass
from http import HTTPStatus
from http.cookies import CookieError, SimpleCookie
from importlib.resources import files
from typing import Any
from urllib.parse import parse_qs, quote, unquote, urlsplit

from websockets.asyncio.server import ServerConnection, serve
from websockets.datastructures import Headers
from websockets.http11 import Request, Response

from firstcontact.core import ArgumentError

#: Smallest number of characters of a token.
TOKEN_LENGTH = 16
#: URL path at which a page's scripts open their socket.
SOCKET = "/socket"
LAST_PORT = 65_535
#: Content type and bytes of each file, by URL path.
Files = Mapping[str, tuple[str, bytes]]
#: Size of the system's buffer for a viewer that does not read, bytes.
SENDING_BYTES = 131_072
_SAFE = {
    "Content-Security-Policy": (
        "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self'; "
        "connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
    ),
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cache-Control": "no-cache",
}
TYPES = {
    ".html": "text/html; charset=utf-8",
    ".css": "text/css; charset=utf-8",
    ".js": "text/javascript; charset=utf-8",
    ".svg": "image/svg+xml",
}


class NotAllowedError(Exception):
    """Error for a refused request, with an HTTP status and a sentence for the user."""

    def __init__(self, status: HTTPStatus, sentence: str) -> None:
        super().__init__(sentence)
        self.status = status
        self.sentence = sentence


def is_loopback(host: str) -> bool:
    """Return True if an address, such as "localhost", is reachable from this computer only."""
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return host == "localhost"


@dataclass(frozen=True, slots=True)
class Guard:
    """Access control of the pages: it checks the host name, origin and token of each request.

    Without a token, only this computer may open the pages.
    """

    host: str
    port: int
    #: Secret of viewers that may control the session.
    token: str | None
    #: Secret of viewers that may only look.
    look_token: str | None = None

    @property
    def cookie(self) -> str:
        """Name of the cookie with the token. The port is in it, because cookies ignore ports."""
        return f"firstcontact-{self.port}"

    def url(self, token: str | None) -> str:
        """Return the address to open in a browser, with the token if there is one."""
        host = f"[{self.host}]" if ":" in self.host else self.host
        if self.host in {"0.0.0.0", "::"}:  # noqa: S104  # what a viewer elsewhere can open
            host = socket.gethostname()
        query = "" if token is None else f"?token={quoted(token)}"
        return f"http://{host}:{self.port}/{query}"

    def check(self, path: str, headers: Headers, websocket: bool) -> str | None:
        """Return the token of a request that is allowed, or None if pages need no token.

        Raise NotAllowedError for a wrong host name, origin or token.
        """
        served = headers.get_all("Host")
        if len(served) != 1 or not self._ours(served[0]):
            raise NotAllowedError(
                HTTPStatus.FORBIDDEN,
                "This page is not served under that host name: open the address that the "
                "command printed.",
            )
        if websocket:
            # Browsers always name the page that opens a socket; other programs need not.
            origins = headers.get_all("Origin")
            if origins and origins != [f"http://{served[0]}"]:
                raise NotAllowedError(
                    HTTPStatus.FORBIDDEN,
                    "A page of another site may not connect to this session: open the "
                    "address that the command printed.",
                )
        if self.token is None:
            return None
        query = parse_qs(urlsplit(path).query, errors="surrogateescape")
        for given in (query.get("token", []), [self._from_cookie(headers)]):
            for token in filter(None, (self.token, self.look_token)):
                if len(given) == 1 and _same(given[0], token):
                    return token
        raise NotAllowedError(
            HTTPStatus.UNAUTHORIZED,
            "The token is missing or wrong: open the address that the command printed.",
        )

    def _ours(self, served: str) -> bool:
        try:
            name = urlsplit(f"//{served}").hostname or ""
        except ValueError:
            return False
        if is_loopback(name):
            return True
        if self.token is None:
            return False
        # A numeric address cannot be made to point elsewhere. Names must be this machine's.
        host_name = socket.gethostname().lower()
        try:
            ipaddress.ip_address(name)
        except ValueError:
            return name in {self.host.lower(), host_name, f"{host_name}.local"}
        return True

    def _from_cookie(self, headers: Headers) -> str:
        for line in headers.get_all("Cookie"):
            try:
                cookie = SimpleCookie(line).get(self.cookie)
            except CookieError:
                continue
            if cookie is not None:
                return unquote(cookie.value, errors="surrogateescape")
        return ""


def quoted(token: str) -> str:
    return quote(token, safe="", errors="surrogateescape")


def _same(given: str, token: str) -> bool:
    # Bytes that are no ASCII come as surrogates from a request and from a command line.
    one, other = (word.encode(errors="surrogateescape") for word in (given, token))
    return hmac.compare_digest(one, other)


def load(package: str, folder: str) -> Files:
    """Return content type and bytes of each file in a folder of a package. Keys are URL paths."""
    table = {}
    for item in files(package).joinpath(folder).iterdir():
        suffix = "." + item.name.rpartition(".")[2]
        if suffix in TYPES:
            table["/" + item.name] = TYPES[suffix], item.read_bytes()
    table["/"] = table["/index.html"]
    return table


def answer(request: Request, guard: Guard, served: Files) -> Response | None:
    path = request.path.partition("?")[0]
    websocket = path == SOCKET
    try:
        token = guard.check(request.path, request.headers, websocket)
    except NotAllowedError as error:
        return plain(error.status, error.sentence)
    if websocket:
        return None
    if path not in served:
        return plain(HTTPStatus.NOT_FOUND, "There is no such page.")
    response = _response(HTTPStatus.OK, *served[path])
    if token is not None and "?" in request.path:
        response.headers["Set-Cookie"] = (
            f"{guard.cookie}={quoted(token)}; Path=/; HttpOnly; SameSite=Strict"
        )
    return response


def listen(host: str, port: int) -> socket.socket:
    if not 0 <= port <= LAST_PORT:  # the system would use another port: the number modulo 65,536
        raise ArgumentError(
            f"port {port} does not exist: name one from 1 to {LAST_PORT}, or 0 for a free port"
        )
    try:
        addresses = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE)
        family, _, _, _, address = addresses[0]
        listening = socket.create_server(address[:2], family=family, backlog=64)
    except (OSError, OverflowError) as error:
        raise ArgumentError(
            f"the page cannot be served on {host} port {port} ({error}): name another port or "
            "address, or 0 for a free port"
        ) from error
    # Size of the buffer for a viewer that does not read. The connections inherit it.
    listening.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, SENDING_BYTES)
    return listening


def serve_page(
    view: Callable[[ServerConnection], Awaitable[None]],
    listening: socket.socket,
    answers: Callable[[ServerConnection, Request], Response | None],
    longest: int,
    **more: Any,
) -> AbstractAsyncContextManager[object]:
    # Users do not read the library's log, so it stays silent.
    log = logging.getLogger("firstcontact.page")
    log.setLevel(logging.CRITICAL)
    return serve(
        view,
        sock=listening,
        process_request=answers,
        server_header=None,
        compression=None,
        logger=log,
        open_timeout=3,
        close_timeout=1,
        max_size=longest,
        **more,
    )


def plain(status: HTTPStatus, sentence: str) -> Response:
    return _response(status, "text/plain; charset=utf-8", sentence.encode())


def _response(status: HTTPStatus, kind: str, body: bytes) -> Response:
    headers = Headers(
        **{"Content-Type": kind, "Content-Length": str(len(body)), "Connection": "close", **_SAFE}
    )
    return Response(status.value, status.phrase, headers, body)
