"""Web server of the live page: it serves the files, and updates the page by a WebSocket."""

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
from typing import TYPE_CHECKING, Annotated, Any, Literal

import msgspec
from websockets.asyncio.server import ServerConnection
from websockets.exceptions import ConnectionClosed
from websockets.http11 import Request, Response

from firstcontact.core import ArgumentError, InputError
from firstcontact.core.records import read_record
from firstcontact.device.protocol import marker_text
from firstcontact.streaming.events import Ask
from firstcontact.streaming.page.serving import Guard, answer, plain, serve_page
from firstcontact.streaming.page.state import State

if TYPE_CHECKING:
    from firstcontact.streaming.session import LiveSession

#: Shortest time between two messages to a viewer, and between two requests of a viewer, s.
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
#: Number of bytes that wait in the socket of a slow viewer. Beyond them it skips updates.
WAITING_BYTES = 32_768
#: Longest message of a viewer, bytes.
LONGEST_MESSAGE = 4096
#: Message that shows that the page is alive. It is no request and gets no reply.
HERE = '{"do":"here"}'
_HEAD = struct.Struct("<IId")


@dataclass(frozen=True, slots=True)
class ViewerRequest:
    """Message from a viewer's browser. ``text`` is that of a marker, or a shape."""

    do: Literal["record", "stop", "mark", "new", "shape", "close", "open"]
    text: Annotated[str, msgspec.Meta(max_length=1000)] = ""


class Commands:
    """Handler of the requests that viewers of the page send, for example to close the hand."""

    def __init__(self, controls: LiveSession | None) -> None:
        self._controls = controls

    async def obey(self, message: str | bytes, by: str) -> dict[str, Any]:
        """Carry out the message of the viewer ``by``. Return the fields of the reply.

        ``ok`` is True if it worked, ``do`` names the request, and ``text`` is a sentence for the
        viewer.
        """
        data = message.encode(errors="surrogatepass") if isinstance(message, str) else message
        try:
            request = read_record(
                data,
                ViewerRequest,
                "This message",
                "reload the page",
                LONGEST_MESSAGE,
                ArgumentError,
            )
        except InputError as error:
            return {"ok": False, "do": "", "text": f"That was not understood. {error}."}
        try:
            # A recorder opens files: that may take a while, and only this viewer waits.
            outcome = await asyncio.to_thread(self._do, request, by)
        except InputError as error:
            return {"ok": False, "do": request.do, "text": str(error)}
        except Exception as error:  # a fault of the session is reported and stays there
            return {"ok": False, "do": request.do, "text": f"That did not work ({error!r})."}
        return {"ok": True, "do": request.do, "text": outcome}

    def gone(self, by: str) -> None:
        if self._controls is not None:
            self._controls.hand_gone(by)

    def _do(self, request: ViewerRequest, by: str) -> str:
        controls = self._controls
        if controls is None:
            raise ArgumentError("This page cannot control the session: open the page for control.")
        match request.do:
            case "record":
                return f"Recording to {controls.start_recording().name}."
            case "stop":
                path = controls.stop_recording()
                if path is None:
                    return "No recording was running."
                return f"Recorded {path.name} in the folder {path.parent.resolve()}."
            case "close" | "open":
                controls.ask_hand(Ask(request.do), by)
                return f"The hand {request.do}s."
            case "new":
                controls.new_object()
                return "New object: its pinches are combined."
            case "shape":
                shape = controls.set_shape(request.text)
                return f"Shape of the next objects: {shape or 'unknown'}."
            case "mark":
                word = marker_text(request.text.strip()).decode().strip()
                if not word:
                    raise ArgumentError("The marker's text is empty: type at least one word.")
                controls.mark(word)
                return f"Marked “{word}”."


@dataclass(slots=True)
class _Viewer:
    """Connection to one browser that shows the page."""

    name: str
    connection: ServerConnection
    hello: str
    commands: Commands
    heard: float = 0.0
    closes: bool = False
    pinged: float = math.inf  # time of the ping without a reply; infinite if there is none

    async def watch(self) -> None:
        """Raise TimeoutError once a viewer that has closed the hand is silent for too long."""
        while not self.closes or time.monotonic() - self.heard < SILENCE:
            await asyncio.sleep(TICK)
        raise TimeoutError

    async def ping(self) -> None:
        """Ping the viewer at intervals. If it does not reply, disconnect it.

        Then raise TimeoutError.
        """
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
        """Disconnect the viewer at once. A usual closing would wait for a reply."""
        self.connection.transport.abort()


class PageServer:
    """Web server of the live page, which serves while :meth:`run` runs."""

    def __init__(
        self,
        state: State,
        guard: Guard,
        files: Mapping[str, tuple[str, bytes]],
        controls: LiveSession | None,
    ) -> None:
        self._state = state
        self._guard = guard
        self._files = files
        self._commands = {True: Commands(controls), False: Commands(None)}
        self._viewers: dict[str, _Viewer] = {}
        self._number = 0  # number of the newest viewer

    async def run(self, listening: socket.socket, stop: asyncio.Event) -> None:
        """Serve the page on a socket until ``stop`` is set. Then close the connections."""
        server = serve_page(
            self._view,
            listening,
            self._answer,
            LONGEST_MESSAGE,
            ping_interval=None,
            max_queue=4,
            write_limit=WAITING_BYTES,
        )
        async with server:
            await stop.wait()

    def _answer(self, connection: ServerConnection, request: Request) -> Response | None:
        answered = answer(request, self._guard, self._files)
        # Nothing else runs between this check and `_view`, which counts the viewer.
        if answered is None and len(self._viewers) >= VIEWERS and not self._drop_silent_viewer():
            return plain(
                HTTPStatus.SERVICE_UNAVAILABLE,
                f"{VIEWERS} viewers are watching: close one of them.",
            )
        return answered

    def _drop_silent_viewer(self) -> bool:
        """Disconnect the viewer that has been silent longest, and return True.

        Return False if no viewer is silent.
        """
        slowest = min(self._viewers.values(), key=lambda viewer: viewer.pinged)
        if time.monotonic() - slowest.pinged < GRACE:
            return False
        del self._viewers[slowest.name]
        slowest.drop()
        return True

    async def _view(self, connection: ServerConnection) -> None:
        request = connection.request
        assert request is not None
        token = self._guard.check(request.path, request.headers, True)
        in_control = token == self._guard.token
        self._number += 1
        viewer = _Viewer(
            f"viewer {self._number} of the page",
            connection,
            self._state.hello if in_control else self._state.look_hello,
            self._commands[in_control],
        )
        self._viewers[viewer.name] = viewer
        try:
            async with asyncio.TaskGroup() as tasks:
                work = self._send_changes(connection, viewer), viewer.watch(), viewer.ping()
                watchers = [tasks.create_task(coroutine) for coroutine in work]
                await self._listen(connection, viewer)
                for task in watchers:
                    task.cancel()
        except* (ConnectionClosed, TimeoutError):
            pass
        finally:
            self._viewers.pop(viewer.name, None)
            viewer.commands.gone(viewer.name)

    async def _listen(self, connection: ServerConnection, viewer: _Viewer) -> None:
        """Carry out the requests of one viewer until it disconnects."""
        async for message in connection:
            viewer.heard = time.monotonic()
            if message != HERE:
                answer = await viewer.commands.obey(message, viewer.name)
                if answer["ok"] and answer["do"] in ("close", "open"):
                    viewer.closes = answer["do"] == "close"
                await connection.send(json.dumps({"answer": answer}))
            # Messages of this viewer wait meanwhile at its end of the connection.
            await asyncio.sleep(TICK)

    async def _send_changes(self, connection: ServerConnection, viewer: _Viewer) -> None:
        """Send each changed part of the page's state to a viewer, as fast as the viewer reads."""
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
