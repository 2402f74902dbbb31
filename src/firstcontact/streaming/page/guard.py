"""Access control of the page: viewers on this machine, or with the token."""

from __future__ import annotations

import hmac
import ipaddress
import socket
from dataclasses import dataclass
from http import HTTPStatus
from http.cookies import CookieError, SimpleCookie
from urllib.parse import parse_qs, quote, unquote, urlsplit

from websockets.datastructures import Headers

#: Smallest number of characters of a token.
TOKEN_LENGTH = 16


class NotAllowedError(Exception):
    """Error for a refused request, with its HTTP status and one sentence."""

    def __init__(self, status: HTTPStatus, sentence: str) -> None:
        super().__init__(sentence)
        self.status = status
        self.sentence = sentence


def is_loopback(host: str) -> bool:
    """Return True if an address is reachable from this machine only."""
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return host == "localhost"


@dataclass(frozen=True, slots=True)
class Guard:
    """Access control: checks the headers of every request, also for the WebSocket.

    Parameters
    ----------
    host
        Address that the page is served on, as given by the user.
    port
        Port of the page.
    token
        Secret that viewers must send. With None, only requests to loopback names are served.
    """

    host: str
    port: int
    token: str | None

    @property
    def cookie(self) -> str:
        """Name of the token's cookie. It contains the port, because cookies ignore ports."""
        return f"firstcontact-{self.port}"

    @property
    def quoted(self) -> str:
        """Token, quoted for URLs and cookies."""
        return quote(self.token or "", safe="", errors="surrogateescape")

    @property
    def url(self) -> str:
        """Address to open in a browser. It contains the token if one is needed."""
        host = f"[{self.host}]" if ":" in self.host else self.host
        if self.host in {"0.0.0.0", "::"}:  # noqa: S104  # what a viewer elsewhere can open
            host = socket.gethostname()
        query = "" if self.token is None else f"?token={self.quoted}"
        return f"http://{host}:{self.port}/{query}"

    def check(self, path: str, headers: Headers, websocket: bool) -> bool:
        """Raise an error unless a request has valid headers and, if one is needed, the token.

        Returns
        -------
        bool
            True if the token came in the URL and should become a cookie.

        Raises
        ------
        NotAllowedError
            The request has a foreign host name (DNS rebinding), comes from another site's page, or
            lacks the token.
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
            return False
        query = parse_qs(urlsplit(path).query, errors="surrogateescape")
        given = query.get("token", [])
        if len(given) == 1 and _same(given[0], self.token):
            return True
        if not _same(self._from_cookie(headers), self.token):
            raise NotAllowedError(
                HTTPStatus.UNAUTHORIZED,
                "The token is missing or wrong: open the address that the command printed.",
            )
        return False

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


def _same(given: str, token: str) -> bool:
    # Bytes that are no ASCII come as surrogates from a request and from a command line.
    one, other = (word.encode(errors="surrogateescape") for word in (given, token))
    return hmac.compare_digest(one, other)
