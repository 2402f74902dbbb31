"""Server of the page's files and of the WebSocket that updates it, in one event loop."""

from __future__ import annotations

import asyncio
import json
import math
import socket
import struct
import time
from collections.abc import Mapping
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
#: Time without a reply to a ping after which a viewer is disconnected, and after which it gives its
#: place to a new viewer, s. Data that wait for a slow viewer delay its replies.
PATIENCE, GRACE = 10.0, 2.0
#: Time from a reply to the next ping, s.
PAUSE = 1.0
#: Time after which a silent viewer that closed the hand is disconnected, s. The hand then opens.
SILENCE = 1.5
#: Number of waiting bytes above which a viewer skips updates.
WAITING_BYTES = 32_768
_HEAD = struct.Struct("<IId")


@dataclass(slots=True)
class _Viewer:
    """Viewer of the page, connected by a socket."""

    name: str
    connection: ServerConnection
    hello: str
    commands: Commands
    heard: float = 0.0
    closes: bool = False
    pinged: float = math.inf

    async def watch(self) -> None:
        """Wait until the viewer has closed the hand and is silent, then raise TimeoutError."""
        while not self.closes or time.monotonic() - self.heard < SILENCE:
            await asyncio.sleep(TICK)
        raise TimeoutError

    async def ping(self) -> None:
        """Ping the viewer until it does not reply because it reads nothing, then disconnect it."""
        while True:
            self.pinged = time.monotonic()
            try:
                async with asyncio.timeout(PATIENCE):
                    await (await self.connection.ping())
            except TimeoutError:
                self.drop()
                raise
            self.pinged = math.inf
            await asyncio.sleep(PAUSE)

    def drop(self) -> None:
        """Disconnect the viewer. It reads nothing, so it would not read a closing handshake."""
        self.connection.transport.abort()


class PageServer:
    """Web server of the page. It serves while :meth:`run` runs."""

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
        self._viewers: dict[str, _Viewer] = {}
        self._number = 0  # number of the newest viewer

    async def run(self, listening: socket.socket, stop: asyncio.Event) -> None:
        """Serve until ``stop`` is set, then close the connections."""
        server = serve_page(
            self._view,
            listening,
            self._answer,
            LONGEST,
            ping_interval=None,
            max_queue=4,
            write_limit=WAITING_BYTES,
        )
        async with server:
            await stop.wait()

    def _answer(self, connection: ServerConnection, request: Request) -> Response | None:
        answered = answer(request, self._guard, self._files)
        # Nothing else runs between this check and `_view`, which counts the viewer. A test checks
        # that.
        if answered is None and len(self._viewers) >= VIEWERS and not self._make_room():
            return plain(
                HTTPStatus.SERVICE_UNAVAILABLE,
                f"{VIEWERS} viewers are watching: close one of them.",
            )
        return answered

    def _make_room(self) -> bool:
        """Disconnect the viewer whose reply has been missing longest. Return True if one was."""
        slowest = min(self._viewers.values(), key=lambda viewer: viewer.pinged)
        if time.monotonic() - slowest.pinged < GRACE:
            return False
        del self._viewers[slowest.name]
        slowest.drop()
        return True

    async def _view(self, connection: ServerConnection) -> None:
        self._number += 1
        viewer = self._viewer(connection)
        self._viewers[viewer.name] = viewer
        try:
            async with asyncio.TaskGroup() as tasks:
                work = self._tell(connection, viewer), viewer.watch(), viewer.ping()
                watchers = [tasks.create_task(coroutine) for coroutine in work]
                await self._listen(connection, viewer)
                for task in watchers:
                    task.cancel()
        except* (ConnectionClosed, TimeoutError):
            pass
        finally:
            self._viewers.pop(viewer.name, None)
            viewer.commands.gone(viewer.name)

    def _viewer(self, connection: ServerConnection) -> _Viewer:
        """Return the newest viewer, with controls or without, depending on its token."""
        request = connection.request
        assert request is not None
        token = self._guard.check(request.path, request.headers, True)
        in_control = token == self._guard.token
        return _Viewer(
            f"viewer {self._number} of the page",
            connection,
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
            await connection.send(json.dumps({"answer": answer}))
            # Messages of this viewer wait meanwhile at its end of the connection.
            await asyncio.sleep(wait)

    async def _tell(self, connection: ServerConnection, viewer: _Viewer) -> None:
        """Send changed parts of the state to a viewer, as fast as it reads them."""
        await connection.send(f'{{"hello":{viewer.hello}}}')
        seen: dict[str, int] = {}
        column, skipped = -1, 0
        about: dict[str, Any] = {}
        while True:
            first, values = self._state.columns(max(column, 0))
            if column >= 0:
                skipped += first - column
            column = first + len(values)
            parts = self._state.changed(seen)
            now = {"viewers": len(self._viewers), "skipped": skipped}
            if now != about:
                parts["viewer"], about = json.dumps(now), now
            if len(values):
                head = _HEAD.pack(values.shape[0], values.shape[1], first)
                await connection.send(head + values.astype("<f4").tobytes())
            if parts:
                fields = ",".join(f'"{name}":{text}' for name, text in parts.items())
                await connection.send(f"{{{fields}}}")
            await asyncio.sleep(TICK)
