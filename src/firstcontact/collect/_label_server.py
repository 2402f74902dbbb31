"""Server of the labelling page, on this machine only."""

from __future__ import annotations

import asyncio
import json
import socket
from collections.abc import Callable
from contextlib import suppress

from websockets.asyncio.server import ServerConnection
from websockets.exceptions import ConnectionClosed
from websockets.http11 import Request, Response

from firstcontact.collect._label_session import LONGEST, Session
from firstcontact.core import InputError
from firstcontact.streaming import Guard, answer, listen, load, serve_page

HOST = "127.0.0.1"
#: Interval between polls for a request to stop, s.
POLL = 0.1


class LabelServer:
    """Server of the page of one labelling session.

    Parameters
    ----------
    session
        Session that the page shows.
    port
        TCP port; 0 takes a free one.

    Raises
    ------
    InputError
        The port is in use.
    """

    def __init__(self, session: Session, port: int) -> None:
        self._session = session
        self._files = load("firstcontact.collect", "label_page")
        self._socket: socket.socket = listen(HOST, port)
        self._guard = Guard(HOST, self._socket.getsockname()[1], None)
        self._done = asyncio.Event()
        self._loop: asyncio.AbstractEventLoop | None = None

    @property
    def url(self) -> str:
        """Address to open in a browser."""
        return self._guard.url(None)

    def run(
        self,
        ready: Callable[[], object] = lambda: None,
        is_stopped: Callable[[], bool] = lambda: False,
    ) -> None:
        """Serve until the new recordings are written or the user stops the command.

        Parameters
        ----------
        ready
            Function that is called once the page is served.
        is_stopped
            Function that is polled for a request to stop. Signal handlers must not raise exceptions
            while the server runs: an exception during a reply would be lost in the task of that
            reply.
        """
        try:
            asyncio.run(self._run(ready, is_stopped))
        finally:
            self._socket.close()

    def stop(self) -> None:
        """Stop the server, from any thread."""
        if self._loop is not None:
            self._loop.call_soon_threadsafe(self._done.set)

    async def _run(self, ready: Callable[[], object], is_stopped: Callable[[], bool]) -> None:
        server = serve_page(self._view, self._socket, self._answer, LONGEST)
        self._loop = asyncio.get_running_loop()
        async with server:
            ready()
            while not (self._done.is_set() or is_stopped()):
                with suppress(TimeoutError):
                    await asyncio.wait_for(self._done.wait(), POLL)

    def _answer(self, connection: ServerConnection, request: Request) -> Response | None:
        return answer(request, self._guard, self._files)

    async def _view(self, connection: ServerConnection) -> None:
        with suppress(ConnectionClosed):
            await connection.send(json.dumps(self._session.hello()))
            async for message in connection:
                try:
                    reply = self._session.obey(message)
                except InputError as error:
                    # The page has already shown the refused change. The state reverts it.
                    reply = {"refused": str(error), **self._session.state()}
                await connection.send(json.dumps(reply))
                if self._session.written:
                    self._done.set()
