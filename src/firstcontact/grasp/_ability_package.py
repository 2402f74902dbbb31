"""The published package of the Ability Hand, without what it does to a program.

Version 0.2.2, at import: writes ``config.py`` into the working folder and puts that folder on the
import path; with logging on, sends the root logger to a file there. Opening: ends the process
where no hand answers. Closing: prints, and divides by the number of writes. While it runs:
swallows every error of the port, and its threads outlive the main one.
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

from firstcontact.core import InputError, need

#: The name of a port that stands for the package's own simulated hand.
SIMULATED = "simulated"

_importing = threading.Lock()


class _UnansweredError(Exception):
    """Instead of the end of the process."""


def _unanswered(code: object = None) -> None:
    raise _UnansweredError


def check(port: str | None) -> str:
    """The port, if the package is there and a port was named.

    Raises
    ------
    InputError
        The package is missing, or the port.
    """
    need("hand", "ah_wrapper")
    if port is None:
        raise InputError(
            "the Ability Hand needs its serial port, such as /dev/ttyUSB0 "
            f"({SIMULATED!r} is the simulated hand of its package)"
        )
    return port


@contextmanager
def claimed(port: str) -> Iterator[None]:
    """Hold the port against other programs that ask; the package opens it without asking.

    Raises
    ------
    InputError
        There is no such port, or somebody holds it.
    """
    if port == SIMULATED:
        yield
        return
    try:
        descriptor = os.open(port, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
    except OSError as error:
        raise InputError(
            f"the Ability Hand's port {port} cannot be opened ({error.strerror}): check cable, "
            "name and permission"
        ) from error
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError as error:
        os.close(descriptor)
        raise InputError(
            f"the Ability Hand's port {port} is in use by another program: end that one first"
        ) from error
    try:
        yield
    finally:
        os.close(descriptor)


def open_client(port: str, rate: float) -> Any:
    """A client of the hand on this port that reads by a thread and never writes by itself.

    Its thread ends with the process if called in a daemon thread, and only then.

    Raises
    ------
    InputError
        No hand answers there.
    """
    package = load()
    simulated = port == SIMULATED
    try:
        # It talks on standard output, which may carry data.
        with redirect_stdout(sys.stderr):
            client = package.AHSerialClient(
                port=port,
                rate_hz=rate,
                write_thread=False,
                auto_start_threads=False,
                simulated=simulated,
            )
    except (_UnansweredError, OSError) as error:
        raise InputError(
            f"no Ability Hand answers on {port}: check power, cable and port, and that UART and "
            "byte stuffing are on (We16, We46, We47 in its app)"
        ) from error
    # Its own zero is taken at the first reading in which every sensor feels something,
    # which may be in the middle of a grasp.
    client.hand = package.Hand(addr=client.hand.addr, fsr_offset=False)
    client.print_stats = lambda: None
    client.start_threads()
    return client


def load() -> Any:
    """The package, imported so that it leaves the program alone."""
    with _importing:
        if "ah_wrapper.serial_connection" not in sys.modules:
            with _its_config():
                import_module("ah_wrapper")
        connection: Any = sys.modules["ah_wrapper.serial_connection"]
        # Its ``exit(1)`` also closes standard input.
        connection.exit = _unanswered
        return sys.modules["ah_wrapper"]


@contextmanager
def _its_config() -> Iterator[None]:
    """Let the package find a ``config`` module and a working folder that are nobody's."""
    config: Any = ModuleType("config")
    config.write_log = False
    config.velocity_warning = False
    theirs, path, getcwd = sys.modules.get("config"), list(sys.path), os.getcwd
    with tempfile.TemporaryDirectory() as folder:
        sys.modules["config"] = config
        os.getcwd = lambda: folder
        try:
            yield
        finally:
            os.getcwd = getcwd
            sys.path[:] = path
            del sys.modules["config"]
            if theirs is not None:
                sys.modules["config"] = theirs
