"""Requests of the page's viewers: who may ask, limits, and answers."""

import json
import re
import socket
import threading
import time
from collections.abc import Iterator
from typing import Any

import pytest
from page_feed import DESCRIPTOR, Requests, port, view
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import ClientConnection, connect

from firstcontact.core import InputError
from firstcontact.streaming.events import Ask
from firstcontact.streaming.page import server
from firstcontact.streaming.page.server import HERE
from firstcontact.streaming.page.sink import PageSink
from page_browser import PATIENCE, UPGRADE, ask
from processes import until

MARK = '{"do": "mark", "text": "apple"}'


def answer(viewer: ClientConnection) -> dict[str, Any]:
    while True:
        message = viewer.recv(timeout=PATIENCE)
        if isinstance(message, str) and "answer" in (tree := json.loads(message)):
            return dict(tree["answer"])


def test_the_look_only_address_shows_the_page_and_reaches_nothing(requests: Requests) -> None:
    requests.asks = tuple(Ask)
    sink = PageSink(port=0, token="a-token-of-enough-length", controls=requests)
    sink.open(DESCRIPTOR)
    try:
        for address, is_allowed in ((sink.viewer_url, False), (sink.url, True)):
            socket = address.replace("http", "ws").replace("/?", "/socket?")
            with connect(socket, close_timeout=0.5, compression=None) as viewer:
                hello = json.loads(viewer.recv(timeout=PATIENCE))["hello"]
                assert hello["controls"] is hello["uses_shape"] is is_allowed
                assert bool(hello["hand_asks"]) is is_allowed
                for do in ("close", "open", "record", "stop", "new", "shape"):
                    viewer.send(json.dumps({"do": do}))
                    assert answer(viewer)["ok"] is is_allowed, do
                viewer.send(MARK)
                assert answer(viewer)["ok"] is is_allowed
            assert bool(requests.calls) is is_allowed
    finally:
        sink.close()


def test_the_hand_is_asked_by_a_viewer_that_has_a_name(page: PageSink, requests: Requests) -> None:
    with view(page) as first, view(page) as second:
        for viewer, request in ((first, "close"), (second, "open")):
            viewer.send(json.dumps({"do": request}))
            assert answer(viewer)["ok"]
        (closed, first_name), (opened, second_name) = (c.split(" ", 1) for c in requests.calls)
        assert (closed, opened) == ("close", "open")
        assert first_name != second_name
        first.close()
        until = time.monotonic() + PATIENCE
        while requests.gone != [first_name]:
            assert time.monotonic() < until, requests.gone
            assert second.recv(timeout=PATIENCE)


def test_the_hand_opens_despite_many_requests(page: PageSink, requests: Requests) -> None:
    with view(page) as viewer:
        for _ in range(20):
            viewer.send(MARK)
        viewer.send('{"do":"open"}')
        while not any(call.startswith("open ") for call in requests.calls):
            assert answer(viewer)["ok"]


def test_a_viewer_that_falls_silent_no_longer_holds_the_hand_closed(
    page: PageSink, requests: Requests
) -> None:
    assert server.SILENCE + server.TICK < 2.0
    with view(page) as sleeping, view(page) as watching:
        for viewer in (sleeping, watching):
            viewer.send('{"do": "close"}')
            assert answer(viewer)["ok"]
        watching.send('{"do":"open"}')  # and nothing more: it may be as silent as it wants
        assert answer(watching)["ok"]
        # Its socket stays open, and its library answers the server's pings.
        until(lambda: requests.gone)
        names = [call.split(" ", 1)[1] for call in requests.calls]
        assert requests.gone == [names[0]]
        with pytest.raises(ConnectionClosed):
            answer(sleeping)
        watching.send(MARK)
        assert answer(watching)["ok"], "others stay"


def test_a_viewer_that_says_that_it_is_there_holds_the_hand_closed(
    page: PageSink, requests: Requests
) -> None:
    pause = threading.Event()
    with view(page) as viewer:
        viewer.send('{"do": "close"}')
        assert answer(viewer)["ok"]
        until = time.monotonic() + 1.5 * server.SILENCE
        while time.monotonic() < until:
            viewer.send(HERE)
            pause.wait(0.025)
        assert requests.gone == []
        viewer.send(MARK)
        assert answer(viewer)["ok"]


TOKEN = "a-token-of-enough-length"


@pytest.fixture
def guarded() -> Iterator[PageSink]:
    sink = PageSink(port=0, token=TOKEN)
    sink.open(DESCRIPTOR)
    yield sink
    sink.close()


def test_files_are_served_and_locked_down(page: PageSink) -> None:
    status, head, body = ask(port(page), "/")
    assert status == 200
    assert b"<title>" in body
    assert "frame-ancestors 'none'" in head
    assert "nosniff" in head
    for name in ("page.css", "main.js", "icon.svg"):
        status, head, body = ask(port(page), f"/{name}?x=1")
        assert (status, len(body)) == (200, int(head.split("Content-Length: ")[1].split()[0]))


@pytest.mark.parametrize(
    "path",
    [
        "/../server.py",
        "/..%2fserver.py",
        "/%2e%2e/%2e%2e/events.py",
        "//etc/passwd",
        "/static/index.html",
        "/page.css/",
        "/page.css%00",
        "/nothing",
        "page.css",
        "http://127.0.0.1/page.css",
    ],
)
def test_nothing_else_is_served(page: PageSink, path: str) -> None:
    assert ask(port(page), path)[0] == 404


@pytest.mark.parametrize("host", ["evil.example", "evil.example:8765", "10.0.0.7", "[", "a@b@c"])
@pytest.mark.parametrize("path", ["/", "/socket"])
def test_other_names_are_refused(page: PageSink, host: str, path: str) -> None:
    assert ask(port(page), path, host=host, **UPGRADE)[0] == 403


@pytest.mark.parametrize(
    "origin", ["http://evil.example", "null", "http://127.0.0.1:1", "https://127.0.0.1"]
)
def test_other_sites_get_no_socket(page: PageSink, origin: str) -> None:
    assert ask(port(page), "/socket", Origin=origin, **UPGRADE)[0] == 403


def test_the_page_itself_gets_its_socket(page: PageSink) -> None:
    own_values = f"http://127.0.0.1:{port(page)}"
    assert ask(port(page), "/socket", Origin=own_values, **UPGRADE)[0] == 101
    assert ask(port(page), "/socket", **UPGRADE)[0] == 101


@pytest.mark.parametrize("path", ["/", "/page.css", "/socket", "/nothing"])
@pytest.mark.parametrize(
    "given", ["", "?token=", "?token=wrong", f"?token={TOKEN}&token=x", "?token=%FF"]
)
def test_without_the_token_there_is_nothing(guarded: PageSink, path: str, given: str) -> None:
    assert ask(port(guarded), path + given, **UPGRADE)[0] == 401


def test_the_token_opens_the_page_and_its_cookie_all_files(guarded: PageSink) -> None:
    assert guarded.url.endswith(f"?token={TOKEN}")
    status, head, _ = ask(port(guarded), f"/?token={TOKEN}")
    assert status == 200
    line = head.split("Set-Cookie: ")[1].splitlines()[0]
    assert "HttpOnly" in line
    assert "SameSite=Strict" in line
    cookie = line.split(";")[0]
    assert ask(port(guarded), "/main.js", Cookie=cookie)[0] == 200
    assert ask(port(guarded), "/socket", Cookie=cookie, **UPGRADE)[0] == 101
    assert ask(port(guarded), f"/socket?token={TOKEN}", **UPGRADE)[0] == 101
    assert ask(port(guarded), "/main.js", Cookie=cookie[:-1])[0] == 401
    assert ask(port(guarded), "/main.js", Cookie="(=;;@")[0] == 401
    evil = {"Origin": "http://evil.example", **UPGRADE}
    assert ask(port(guarded), "/socket", Cookie=cookie, **evil)[0] == 403


def test_the_newest_address_decides_in_a_browser_with_the_other_cookie(guarded: PageSink) -> None:
    """A page from the look-only address keeps its token, although the browser had the other."""
    look = guarded.viewer_url
    assert TOKEN not in look
    cookie = f"firstcontact-{port(guarded)}={TOKEN}"
    _, head, _ = ask(port(guarded), look[look.index("/?") :], Cookie=cookie)
    cookie = head.split("Set-Cookie: ")[1].splitlines()[0].split(";")[0]
    assert TOKEN not in cookie
    status, head, _ = ask(port(guarded), "/main.js", Cookie=cookie)
    assert (status, "Set-Cookie" in head) == (200, False)


@pytest.mark.parametrize(
    "token",
    [
        "a&b#c%41 d+e?f=g/h",
        "quotes \" and ' too; or $HOME",
        "Schlüssel, größer",
        "x" * 16 + "\udcff\r\n",
    ],
)
def test_the_printed_address_opens_whatever_the_token_is(token: str) -> None:
    sink = PageSink(port=0, token=token)
    sink.open(DESCRIPTOR)
    try:
        address = sink.url
        assert re.fullmatch(r"http://127\.0\.0\.1:\d+/\?token=[\w.~%-]+", address, re.ASCII)
        status, head, _ = ask(port(sink), address[address.index("/?") :])
        assert status == 200
        cookie = head.split("Set-Cookie: ")[1].splitlines()[0].split(";")[0]
        assert ask(port(sink), "/socket", Cookie=cookie, **UPGRADE)[0] == 101
        assert ask(port(sink), "/", Cookie=cookie + "x")[0] == 401
    finally:
        sink.close()


def test_beyond_this_machine_only_with_a_token() -> None:
    sink = PageSink("0.0.0.0", 0)
    sink.open(DESCRIPTOR)
    try:
        token = sink.url.partition("?token=")[2]
        assert len(token) >= 32
        other = PageSink("0.0.0.0", 0)
        other.close()
        assert token not in other.url
        assert ask(port(sink), "/", host="192.0.2.1")[0] == 401
        assert ask(port(sink), f"/?token={token}", host="192.0.2.1:80")[0] == 200
        assert ask(port(sink), f"/?token={token}", host=socket.gethostname())[0] == 200
        assert ask(port(sink), f"/?token={token}", host="evil.example")[0] == 403
    finally:
        sink.close()


def test_a_busy_port_and_a_wrong_address_are_one_sentence(page: PageSink) -> None:
    with pytest.raises(InputError, match=rf"port {port(page)} .*name another port"):
        PageSink(port=port(page))
    with pytest.raises(InputError, match=r"192\.0\.2\.1"):
        PageSink("192.0.2.1", 0)
    with pytest.raises(InputError, match="at least 16"):
        PageSink(port=0, token="short")
