"""Page sink without a browser: messages to viewers, and limits for viewers."""

import json
import socket
import threading
import tracemalloc
from collections.abc import Callable
from contextlib import ExitStack, suppress
from http import HTTPStatus
from typing import Any

import numpy as np
import pytest
from page_feed import DESCRIPTOR, LANDMARKS, Feed, Requests, port, view
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import ClientConnection

from firstcontact.device.protocol import MARKER_BYTES
from firstcontact.streaming import Update
from firstcontact.streaming.page.sink import PageSink
from page_browser import PATIENCE, UPGRADE
from processes import until

HEAD = "".join(f"{k.replace('_', '-')}: {v}\r\n" for k, v in UPGRADE.items())
#: Asks for the socket.
OPENING = f"GET /socket HTTP/1.1\r\nHost: localhost\r\n{HEAD}\r\n".encode()


def merged(viewer: ClientConnection, wanted: Callable[[dict[str, Any]], bool]) -> dict[str, Any]:
    """Return the merged messages of the page once they meet a condition."""
    so_far: dict[str, Any] = {"columns": 0, "first": None, "skipped": 0}
    while not wanted(so_far):
        message = viewer.recv(timeout=PATIENCE)
        if isinstance(message, bytes):
            n, channels = np.frombuffer(message, "<u4", 2)
            first = np.frombuffer(message, "<f8", 1, 8)[0]
            assert len(message) == 16 + 8 * n * channels
            if so_far["first"] is None:
                so_far["first"] = first
            else:
                skipped = first - (so_far["first"] + so_far["columns"] + so_far["skipped"])
                assert skipped >= 0
                so_far["skipped"] += skipped
            so_far["columns"] += int(n)
        else:
            so_far |= json.loads(message)
    return so_far


def test_who_comes_late_has_the_last_seconds_and_pinches_at_once(page: PageSink) -> None:
    feed = Feed()
    for _ in range(400):
        page.take(feed.update())
    with view(page) as viewer:
        got = merged(viewer, lambda s: "pinches" in s and s["columns"] > 0)
    assert got["hello"]["source"] == "twin"
    assert got["hello"]["landmarks"] == LANDMARKS
    assert got["columns"] * got["hello"]["column_samples"] >= 2.0 * got["hello"]["rate"]
    assert [p["pinch"]["number"] for p in got["pinches"]] == list(
        range(feed.pinches - 11, feed.pinches + 1)
    )
    assert got["health"]["samples"] == feed.sample


def test_columns_come_once_and_in_order(page: PageSink) -> None:
    feed = Feed()
    with view(page) as viewer:
        merged(viewer, lambda s: "hello" in s)
        for _ in range(40):
            page.take(feed.update(99))
        got = merged(viewer, lambda s: s["columns"] >= (feed.sample - 1) // 8)
    assert got["first"] == 0
    assert got["skipped"] == 0
    assert got.get("viewer", {"skipped": 0})["skipped"] == 0


@pytest.mark.parametrize(
    "message",
    ["", "{", "[]", "7", "null", '{"do": null}', '{"do": "mark"}', '{"do": "mark", "text": " "}',
     '{"do": "rm"}', b"\xff\x00", "[" * 4000, '{"do": {"do": 1}}'],
)  # fmt: skip
def test_nonsense_is_answered_and_nothing_else_happens(
    page: PageSink, requests: Requests, message: str | bytes
) -> None:
    with view(page) as viewer:
        viewer.send(message)
        got = merged(viewer, lambda s: "answer" in s)
        assert got["answer"]["ok"] is False
        viewer.send('{"do": "mark", "text": " after "}')
        merged(viewer, lambda s: s.get("answer", {}).get("ok") is True)
    assert requests.calls == ["mark after"]


@pytest.mark.parametrize("word", ["ü" * 150, "é" + "x" * 199 + "é", "x" * 199 + "🍎", "apple"])
def test_a_marker_is_told_as_it_is_set(page: PageSink, requests: Requests, word: str) -> None:
    with view(page) as viewer:
        viewer.send(json.dumps({"do": "mark", "text": word}))
        got = merged(viewer, lambda s: "answer" in s)["answer"]
    assert got["ok"] is True
    (call,) = requests.calls
    set_to = call.removeprefix("mark ")
    assert got["text"] == f"Marked “{set_to}”."
    assert word.startswith(set_to)
    assert len(set_to.encode()) <= MARKER_BYTES
    assert len(word.encode()) <= MARKER_BYTES or len(set_to.encode()) > MARKER_BYTES - 4


def test_a_message_too_long_ends_that_viewer_only(page: PageSink) -> None:
    feed = Feed()
    with view(page) as other, view(page) as viewer:
        viewer.send("x" * 100_000)
        with pytest.raises(ConnectionClosed):
            merged(viewer, lambda s: False)
        page.take(feed.update())
        merged(other, lambda s: "health" in s)


def test_controls_that_refuse_or_raise_are_reported(page: PageSink, requests: Requests) -> None:
    requests.refuses = True
    with view(page) as viewer:
        viewer.send('{"do": "record"}')
        got = merged(viewer, lambda s: "answer" in s)
        assert got["answer"]["text"].startswith("the folder cannot be written to")

        def broken(text: str) -> None:
            raise RuntimeError("the cable is a noodle")

        requests.mark = broken  # type: ignore[method-assign]
        viewer.send('{"do": "mark", "text": "x"}')
        got = merged(viewer, lambda s: "answer" in s)
        assert "noodle" in got["answer"]["text"]


def test_one_viewer_too_many_is_refused(page: PageSink) -> None:
    with ExitStack() as viewers:
        for _ in range(16):
            merged(viewers.enter_context(view(page)), lambda s: "hello" in s)
        with pytest.raises(InvalidStatus) as refused:
            viewers.enter_context(view(page))
    assert refused.value.response.status_code == HTTPStatus.SERVICE_UNAVAILABLE


def deaf(sink: PageSink) -> socket.socket:
    """Connect a viewer that never reads."""
    line = socket.socket()
    line.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
    line.settimeout(PATIENCE)
    line.connect(("127.0.0.1", port(sink)))
    line.sendall(OPENING)
    return line


def test_viewers_that_never_read_cost_nothing(page: PageSink) -> None:
    feed = Feed()
    page.take(feed.update())
    lines = [deaf(page) for _ in range(8)]
    try:
        with view(page) as viewer:
            merged(viewer, lambda s: s.get("viewer", {}).get("viewers") == 9)
            tracemalloc.start()
            for _ in range(200):  # they fill what the page keeps for new viewers
                page.take(feed.update())
            previous = tracemalloc.get_traced_memory()[0]
            for k in range(1500):
                page.take(feed.update())
                if k % 100 == 0:
                    # It goes on being told, whatever the others do.
                    merged(viewer, lambda s: s.get("health", {}).get("samples") == feed.sample)
            grown = tracemalloc.get_traced_memory()[0] - previous
            tracemalloc.stop()
        # Each may hold back a socket's buffer and what waits for it, not the 75 s that came.
        assert grown < 8 * 200_000
        assert feed.pinches > 50
    finally:
        for line in lines:
            line.close()


def test_a_deaf_viewer_is_let_go_and_its_place_is_free(
    page: PageSink, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("firstcontact.streaming.page.server.PATIENCE", 0.5)
    feed = Feed()
    page.take(feed.update())
    line = deaf(page)
    stop = threading.Event()

    def go_on() -> None:
        while not stop.wait(0.005):
            page.take(feed.update())

    feeding = threading.Thread(target=go_on)
    try:
        with view(page) as viewer:
            merged(viewer, lambda s: s.get("viewer", {}).get("viewers") == 2)
            feeding.start()
            merged(viewer, lambda s: s.get("viewer", {}).get("viewers") == 1)
    finally:
        stop.set()
        feeding.join()
        line.close()


def test_viewers_that_never_read_give_their_places_to_others(
    page: PageSink, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("firstcontact.streaming.page.server.GRACE", 0.1)
    monkeypatch.setattr("firstcontact.streaming.page.server.PATIENCE", 10 * PATIENCE)
    with ExitStack() as stack:
        for _ in range(16):
            stack.enter_context(deaf(page))
        viewers = 0
        while viewers < 2:  # each of them gets the place of another
            with suppress(InvalidStatus):
                merged(stack.enter_context(view(page)), lambda s: "hello" in s)
                viewers += 1


def test_closing_does_not_wait_for_the_deaf(page: PageSink) -> None:
    feed = Feed()
    lines = [deaf(page) for _ in range(3)]
    half = socket.create_connection(("127.0.0.1", port(page)), timeout=PATIENCE)
    half.sendall(b"GET / HT")
    for _ in range(100):
        page.take(feed.update())
    page.close()
    with pytest.raises(OSError, match="refused"):
        socket.create_connection(("127.0.0.1", port(page)), timeout=PATIENCE)
    for line in (*lines, half):
        line.close()


def test_a_page_whose_thread_died_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    async def dies(*_: object) -> None:
        raise RuntimeError("no loop")

    monkeypatch.setattr("firstcontact.streaming.page.server.PageServer.run", dies)
    sink, threads = PageSink(port=0), set(threading.enumerate())
    sink.open(DESCRIPTOR)
    until(lambda: set(threading.enumerate()) <= threads)
    with pytest.raises(RuntimeError, match="RuntimeError: no loop"):
        sink.take(Update())
    sink.close()
