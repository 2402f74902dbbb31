"""Requests of viewers are checked, bounded and answered."""

import json
import threading
import time
from typing import Any

import pytest
from page_feed import DESCRIPTOR, Requests, view
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import ClientConnection, connect

from firstcontact.streaming.events import Ask
from firstcontact.streaming.page import server
from firstcontact.streaming.page.server import HERE
from firstcontact.streaming.page.sink import PageSink
from page_browser import PATIENCE
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
        assert sink.viewer_url is not None
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
