"""Sink of a live session that serves the live page."""

from __future__ import annotations

import asyncio
import contextlib
import secrets
import threading
from collections.abc import Mapping

from firstcontact.core import ArgumentError
from firstcontact.core.quantity import QUANTITIES
from firstcontact.device import Descriptor
from firstcontact.models import Model
from firstcontact.streaming._sinks import Update
from firstcontact.streaming.outputs import OutputKind, OutputOptions
from firstcontact.streaming.page.server import PageServer
from firstcontact.streaming.page.serving import TOKEN_LENGTH, Guard, is_loopback, listen, load
from firstcontact.streaming.page.state import State
from firstcontact.streaming.session import LiveSession


class PageSink:
    """Sink that serves the live page from :meth:`open` to :meth:`close`.

    The constructor opens the port, so that a busy port is reported early; 0 selects a free one. On
    other addresses than loopback, a token is generated if none is given. ``landmarks`` are the
    Shore A of some objects, to mark on the page's scale.
    """

    name = "page"
    every = 0.05  # as often as viewers get messages

    def __init__(
        self,
        host: str = "127.0.0.1",
        port: int = 8765,
        token: str | None = None,
        controls: LiveSession | None = None,
        landmarks: Mapping[str, float] | None = None,
    ) -> None:
        if token is None and not is_loopback(host):
            token = secrets.token_urlsafe(24)
        if token is not None and len(token) < TOKEN_LENGTH:
            raise ArgumentError(
                f"the page's token has {len(token)} characters, too few to keep others out: "
                f"give at least {TOKEN_LENGTH}, or none for a random one"
            )
        self._files = load("firstcontact.streaming.page", "static")
        self._controls = controls
        self._landmarks = landmarks or {}
        self._socket = listen(host, port)
        look_token = None if token is None else secrets.token_urlsafe(24)
        self._guard = Guard(host, self._socket.getsockname()[1], token, look_token)
        self._state: State | None = None
        self._thread: threading.Thread | None = None
        self._loop: asyncio.AbstractEventLoop | None = None
        self._stop: asyncio.Event | None = None
        self._started = threading.Event()
        self._died = ""

    @property
    def url(self) -> str:
        """Address to open in a browser. It contains the token if one is needed."""
        return self._guard.url(self._guard.token)

    @property
    def viewer_url(self) -> str | None:
        """Address for viewers who may only look; None if pages need no token."""
        token = self._guard.look_token
        return None if token is None else self._guard.url(token)

    def open(self, descriptor: Descriptor) -> None:
        self._state = State(descriptor, self._landmarks, self._controls)
        self._thread = threading.Thread(target=self._serve, name="page", daemon=True)
        self._thread.start()
        self._started.wait()

    def take(self, update: Update) -> None:
        if self._died:
            raise RuntimeError(
                f"the page is no longer served ({self._died}): start the session again"
            )
        if self._state is not None:
            self._state.take(update)

    def close(self) -> None:
        """Disconnect all viewers, and release the port. A second call does nothing."""
        if self._thread is not None and self._loop is not None and self._stop is not None:
            with contextlib.suppress(RuntimeError):  # the loop ended by itself
                self._loop.call_soon_threadsafe(self._stop.set)
            self._thread.join()
            self._thread = None
        self._socket.close()

    def _serve(self) -> None:
        try:
            asyncio.run(self._run())
        except Exception as error:  # reported with the next update
            self._died = f"{type(error).__name__}: {error}"
        finally:
            self._started.set()

    async def _run(self) -> None:
        self._loop, self._stop = asyncio.get_running_loop(), asyncio.Event()
        assert self._state is not None
        server = PageServer(self._state, self._guard, self._files, self._controls)
        self._started.set()
        await server.run(self._socket, self._stop)


def _make(session: LiveSession, options: OutputOptions) -> PageSink:
    landmarks = {} if session.model is None else _landmarks(session.model)
    sink = PageSink(options.address, options.port, options.token, session, landmarks)
    session.notify(f"page: {sink.url}")
    if sink.viewer_url is not None:
        session.notify(f"page without controls, for viewers: {sink.viewer_url}")
    return sink


def _landmarks(model: Model) -> dict[str, float]:
    """Return the mean label of each object in the model's training data, by the object's name.

    The page marks these values on its scale.
    """
    data = model.trained_on
    if not model.predictors or model.default().quantity.name != data.target:
        return {}
    if model.windows and data.objects:
        return dict(data.objects)
    words = QUANTITIES[data.target].label_words
    return {words(level): level for level in data.levels}


PAGE = OutputKind("page", _make)
