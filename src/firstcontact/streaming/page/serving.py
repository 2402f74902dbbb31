"""Static files and response headers of the served pages."""

from __future__ import annotations

import logging
import socket
from collections.abc import Awaitable, Callable, Mapping
from contextlib import AbstractAsyncContextManager
from http import HTTPStatus
from importlib.resources import files
from typing import Any

from websockets.asyncio.server import ServerConnection, serve
from websockets.datastructures import Headers
from websockets.http11 import Request, Response

from firstcontact.core import InputError
from firstcontact.streaming.page.guard import Guard, NotAllowedError, quoted

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


def load(package: str, folder: str) -> Files:
    """Return content type and bytes of each file in a package folder, by URL path.

    Only files of the known types are returned, and only returned files are served.
    """
    table = {}
    for item in files(package).joinpath(folder).iterdir():
        suffix = "." + item.name.rpartition(".")[2]
        if suffix in TYPES:
            table["/" + item.name] = TYPES[suffix], item.read_bytes()
    table["/"] = table["/index.html"]
    return table


def answer(request: Request, guard: Guard, served: Files) -> Response | None:
    """Return the response to a request; None lets the request open the WebSocket."""
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
    """Return a listening socket; raise InputError if the address cannot be used."""
    if not 0 <= port <= LAST_PORT:  # the system would use another port: the number modulo 65,536
        raise InputError(
            f"port {port} does not exist: name one from 1 to {LAST_PORT}, or 0 for a free port"
        )
    try:
        addresses = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE)
        family, _, _, _, address = addresses[0]
        listening = socket.create_server(address[:2], family=family, backlog=64)
    except (OSError, OverflowError) as error:
        raise InputError(
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
    """Return the server of a page as a context manager.

    Parameters
    ----------
    view
        Handler of an opened WebSocket.
    listening
        Socket from :func:`listen`.
    answers
        Function that answers a request, or returns None to let it open the WebSocket.
    longest
        Longest message of a viewer, bytes.
    more
        Further options of the server.
    """
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
    """Return a response with one sentence of plain text."""
    return _response(status, "text/plain; charset=utf-8", sentence.encode())


def _response(status: HTTPStatus, kind: str, body: bytes) -> Response:
    headers = Headers(
        **{"Content-Type": kind, "Content-Length": str(len(body)), "Connection": "close", **_SAFE}
    )
    return Response(status.value, status.phrase, headers, body)
