"""Import and use of the Ability Hand's published package without side effects.

Version 0.2.2 has these side effects:

- Import writes ``config.py`` into the working folder and puts that folder on the import path.
  With logging on, it also sends the root logger to a file there.
- Opening ends the process if no hand answers.
- Closing prints statistics, for which it divides by a number of writes that may be 0.
- The package's threads ignore every error of the port and outlive the main thread.
"""

from __future__ import annotations

import fcntl
import os
import sys
import tempfile
import threading
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stdout
from importlib import import_module
from types import ModuleType
from typing import Any

from firstcontact.core import DeviceError
from firstcontact.core.installation import require_modules

#: Port that stands for the package's own simulated hand.
SIMULATED = "simulated"

_importing = threading.Lock()


class _UnansweredError(Exception):
    """Error raised if no hand answers on the port. The hand's package would end the process."""


def _unanswered(code: object = None) -> None:
    raise _UnansweredError


def check(port: str | None) -> str:
    """Return ``port``. Raise an error if it is None or the hand's package is not installed."""
    require_modules("hand", "ah_wrapper")
    if port is None:
        raise DeviceError(
            "the Ability Hand's serial port is missing: give it, such as --hand-port /dev/ttyUSB0 "
            f"(or {SIMULATED!r}, the simulated hand of its package)"
        )
    return port


@contextmanager
def claimed(port: str) -> Iterator[None]:
    if port == SIMULATED:
        yield
        return
    try:
        descriptor = os.open(port, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
    except OSError as error:
        raise DeviceError(
            f"the Ability Hand's port {port} cannot be opened ({error.strerror}): check cable, "
            "name and permission"
        ) from error
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError as error:
        os.close(descriptor)
        raise DeviceError(
            f"the Ability Hand's port {port} is in use by another program: end that one first"
        ) from error
    try:
        yield
    finally:
        os.close(descriptor)


def open_client(port: str, rate: float) -> Any:
    """Return the package's connection to the hand. It reads the port in its own thread.

    ``rate`` is the rate of the hand's reports, Hz.
    """
    package = load()
    simulated = port == SIMULATED
    try:
        # The package prints to standard output, which may carry data.
        with redirect_stdout(sys.stderr):
            client = package.AHSerialClient(
                port=port,
                rate_hz=rate,
                write_thread=False,
                auto_start_threads=False,
                simulated=simulated,
            )
    except (_UnansweredError, OSError) as error:
        raise DeviceError(
            f"no Ability Hand answers on {port}: check power, cable and port, and that UART and "
            "byte stuffing are on (We16, We46, We47 in its app)"
        ) from error
    # The package takes the first reading in which every sensor is loaded as zero force. That may be
    # in the middle of a grasp.
    client.hand = package.Hand(addr=client.hand.addr, fsr_offset=False)
    client.print_stats = lambda: None
    client.start_threads()
    return client


def load() -> Any:
    """Import the Ability Hand's package without side effects, and return the module."""
    with _importing:
        if "ah_wrapper.serial_connection" not in sys.modules:
            with _isolated_config():
                import_module("ah_wrapper")
        connection: Any = sys.modules["ah_wrapper.serial_connection"]
        # The package's ``exit(1)`` would also close standard input.
        connection.exit = _unanswered
        return sys.modules["ah_wrapper"]


@contextmanager
def _isolated_config() -> Iterator[None]:
    config: Any = ModuleType("config")
    config.write_log = False
    config.velocity_warning = False
    original, path, getcwd = sys.modules.get("config"), list(sys.path), os.getcwd
    with tempfile.TemporaryDirectory() as folder:
        sys.modules["config"] = config
        os.getcwd = lambda: folder
        try:
            yield
        finally:
            os.getcwd = getcwd
            sys.path[:] = path
            del sys.modules["config"]
            if original is not None:
                sys.modules["config"] = original
