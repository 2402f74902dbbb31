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
        Secret of viewers that may control the session. With None, only requests to loopback names
        are served.
    look_token
        Secret of viewers that may only look; None for no such viewers.
    """

    host: str
    port: int
    token: str | None
    look_token: str | None = None

    @property
    def cookie(self) -> str:
        """Name of the token's cookie. It contains the port, because cookies ignore ports."""
        return f"firstcontact-{self.port}"

    def url(self, token: str | None) -> str:
        """Return the address to open in a browser, with a token if one is needed."""
        host = f"[{self.host}]" if ":" in self.host else self.host
        if self.host in {"0.0.0.0", "::"}:  # noqa: S104  # what a viewer elsewhere can open
            host = socket.gethostname()
        query = "" if token is None else f"?token={quoted(token)}"
        return f"http://{host}:{self.port}/{query}"

    def check(self, path: str, headers: Headers, websocket: bool) -> str | None:
        """Raise an error unless a request has valid headers and, if one is needed, a token.

        Returns
        -------
        str or None
            Token of the request; None if none is needed. In a URL, it should become a cookie.

        Raises
        ------
        NotAllowedError
            The request has a foreign host name (DNS rebinding), comes from another site's page, or
            lacks a token.
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
    """Return a token, quoted for URLs and cookies."""
    return quote(token, safe="", errors="surrogateescape")


def _same(given: str, token: str) -> bool:
    # Bytes that are no ASCII come as surrogates from a request and from a command line.
    one, other = (word.encode(errors="surrogateescape") for word in (given, token))
    return hmac.compare_digest(one, other)
