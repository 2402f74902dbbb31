"""Server of the page's files and of the WebSocket that updates it, in one event loop."""

from __future__ import annotations

import asyncio
import json
import socket
import struct
import time
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from http import HTTPStatus
from typing import Any

from websockets.asyncio.server import ServerConnection
from websockets.exceptions import ConnectionClosed
from websockets.http11 import Request, Response

from firstcontact.streaming._sink import Controls
from firstcontact.streaming.page._commands import EACH, HERE, LONGEST, Allowance, Commands
from firstcontact.streaming.page._state import State
from firstcontact.streaming.page.guard import Guard
from firstcontact.streaming.page.serving import answer, plain, serve_page

#: Shortest time between two messages to a viewer, s.
TICK = 0.05
#: Largest number of viewers. It limits their total cost.
VIEWERS = 16
#: Time after which a viewer that reads nothing is disconnected, s.
PATIENCE = 10.0
#: Time after which a silent viewer that closed the hand is disconnected, s. The hand then opens.
SILENCE = 1.5
#: Number of waiting bytes above which a viewer skips updates.
WAITING_BYTES = 32_768
_HEAD = struct.Struct("<IId")


@dataclass(slots=True)
class _Viewer:
    """Viewer of the page, connected by a socket.

    Parameters
    ----------
    name
        Name of the viewer as the origin of requests to the hand.
    heard
        Time of the viewer's newest message, s of the monotonic clock.
    hello
        JSON of all data that do not change.
    commands
        Handler of the viewer's requests.
    closes
        True if the viewer's last request to the hand was to close it.
    """

    name: str
    hello: str
    commands: Commands
    heard: float = 0.0
    closes: bool = False

    async def watch(self) -> None:
        """Wait until the viewer has closed the hand and is silent, then raise TimeoutError.

        The keepalive of the WebSocket library does not detect a page that hangs, because the
        browser itself replies to it.
        """
        while not self.closes or time.monotonic() - self.heard < SILENCE:
            await asyncio.sleep(TICK)
        raise TimeoutError


class PageServer:
    """Web server of the page. It serves while :meth:`run` runs.

    Parameters
    ----------
    state
        State of the page.
    guard
        Access control.
    files
        Served files: content type and bytes, by path.
    controls
        Controls for viewers; None if all viewers may only look.
    """

    def __init__(
        self,
        state: State,
        guard: Guard,
        files: Mapping[str, tuple[str, bytes]],
        controls: Controls | None,
    ) -> None:
        self._state = state
        self._guard = guard
        self._files = files
        self._commands = {True: Commands(controls), False: Commands(None)}
        self._viewers = 0
        self._number = 0  # number of the newest viewer

    async def run(self, listening: socket.socket, stop: asyncio.Event) -> None:
        """Serve until ``stop`` is set, then close the connections."""
        server = serve_page(
            self._view,
            listening,
            self._answer,
            LONGEST,
            ping_interval=PATIENCE / 2,
            ping_timeout=PATIENCE,
            max_queue=4,
            write_limit=WAITING_BYTES,
        )
        async with server:
            await stop.wait()

    def _answer(self, connection: ServerConnection, request: Request) -> Response | None:
        answered = answer(request, self._guard, self._files)
        # Nothing else runs between this check and `_view`, which counts the viewer. A test checks
        # that.
        if answered is None and self._viewers >= VIEWERS:
            return plain(
                HTTPStatus.SERVICE_UNAVAILABLE,
                f"{VIEWERS} viewers are watching: close one of them.",
            )
        return answered

    async def _view(self, connection: ServerConnection) -> None:
        self._viewers += 1
        self._number += 1
        viewer = self._viewer(connection)
        try:
            async with asyncio.TaskGroup() as tasks:
                work = self._tell(connection, viewer), viewer.watch()
                watchers = [tasks.create_task(coroutine) for coroutine in work]
                await self._listen(connection, viewer)
                for task in watchers:
                    task.cancel()
        except* (ConnectionClosed, TimeoutError):
            pass
        finally:
            self._viewers -= 1
            viewer.commands.gone(viewer.name)

    def _viewer(self, connection: ServerConnection) -> _Viewer:
        """Return the newest viewer, with controls or without, depending on its token."""
        request = connection.request
        assert request is not None
        token = self._guard.check(request.path, request.headers, True)
        in_control = token == self._guard.token
        return _Viewer(
            f"viewer {self._number} of the page",
            self._state.hello if in_control else self._state.look_hello,
            self._commands[in_control],
        )

    async def _listen(self, connection: ServerConnection, viewer: _Viewer) -> None:
        """Carry out the requests of a viewer until it closes the socket."""
        allowance = Allowance(*EACH)
        async for message in connection:
            viewer.heard = time.monotonic()
            if message == HERE:
                await asyncio.sleep(TICK)
                continue
            answer, wait = await viewer.commands.obey(message, allowance, viewer.name)
            if answer["ok"] and answer["do"] in ("close", "open"):
                viewer.closes = answer["do"] == "close"
            await self._send(connection, json.dumps({"answer": answer}))
            # Messages of this viewer wait meanwhile at its end of the connection.
            await asyncio.sleep(wait)

    async def _tell(self, connection: ServerConnection, viewer: _Viewer) -> None:
        """Send changed parts of the state to a viewer, as fast as it reads them."""
        await self._send(connection, f'{{"hello":{viewer.hello}}}')
        seen: dict[str, int] = {}
        column, skipped = -1, 0
        about: dict[str, Any] = {}
        while True:
            first, values = self._state.columns(max(column, 0))
            if column >= 0:
                skipped += first - column
            column = first + len(values)
            parts = self._state.changed(seen)
            now = {"viewers": self._viewers, "skipped": skipped}
            if now != about:
                parts["viewer"], about = json.dumps(now), now
            if len(values):
                head = _HEAD.pack(values.shape[0], values.shape[1], first)
                await self._send(connection, head + values.astype("<f4").tobytes())
            if parts:
                fields = ",".join(f'"{name}":{text}' for name, text in parts.items())
                await self._send(connection, f"{{{fields}}}")
            await asyncio.sleep(TICK)

    async def _send(self, connection: ServerConnection, message: str | bytes) -> None:
        try:
            async with asyncio.timeout(PATIENCE):
                await connection.send(message)
        except TimeoutError:
            # The viewer does not read, so it would not read a closing handshake either.
            with suppress(AttributeError):
                connection.transport.abort()
            raise
