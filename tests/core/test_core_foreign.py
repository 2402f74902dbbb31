"""Exceptions of foreign code become an InputError that names the code."""

from __future__ import annotations

import os
import pickle
import signal
import sys
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from types import ModuleType

import pytest

from firstcontact.cli.stopping import stopping
from firstcontact.core import ForeignCode, InputError, culprit, register_foreign, summarize_error
from firstcontact.core import _foreign as foreign


class Odd(BaseException):
    """Exception that does not derive from Exception, and is not built in."""


class MuteError(Exception):
    """Exception whose message cannot be read."""

    def __str__(self) -> str:
        raise SystemExit(0)


RAISED = (
    SystemExit(0), SystemExit("bye"), GeneratorExit(), KeyboardInterrupt(), StopIteration(), Odd(),
    MuteError(), ValueError("no"), OSError("no path"),
)  # fmt: skip


@pytest.fixture(autouse=True)
def _as_a_command() -> Iterator[None]:
    """Install the signal handlers of the command line."""
    with stopping():
        yield


@pytest.fixture
def stranger(monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    """Return a module of another package that raises a given exception."""
    monkeypatch.setattr(foreign, "_modules", {})
    module = ModuleType("stranger.inside")
    exec("def fail(error):\n    raise error\n\ndef call(act):\n    return act()\n", vars(module))
    register_foreign("stranger", "the plug-in 'x'")
    return module


@pytest.mark.parametrize("error", RAISED, ids=repr)
def test_any_exception_becomes_an_input_error(error: BaseException) -> None:
    with pytest.raises(InputError) as error_info, ForeignCode("the plug-in 'x'"):
        raise error
    assert "the plug-in 'x'" in str(error_info.value)
    assert type(error).__name__ in str(error_info.value)
    assert error_info.value.__cause__ is error
    assert isinstance(pickle.loads(pickle.dumps(error_info.value)), InputError)


@pytest.mark.parametrize("error", RAISED, ids=repr)
def test_traceback_identifies_the_plugin(error: BaseException, stranger: ModuleType) -> None:
    with pytest.raises(InputError, match="the plug-in 'x'"), ForeignCode():
        stranger.fail(error)


def test_error_caused_by_a_plugin_names_the_plugin(stranger: ModuleType) -> None:
    def steps() -> Iterator[int]:
        yield stranger.fail(StopIteration())

    with pytest.raises(InputError, match=r"'x' .*RuntimeError"), ForeignCode():
        next(steps())


def test_errors_of_this_package_pass_unchanged(stranger: ModuleType) -> None:
    for error in (ValueError("ours"), SystemExit(3), Odd()):
        with pytest.raises(type(error)), ForeignCode():
            raise error
        assert culprit(error) == ""


def test_input_errors_and_missing_files_pass_unchanged(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="mine"), ForeignCode("x"):
        raise InputError("mine")
    with pytest.raises(FileNotFoundError), ForeignCode("x"):
        (tmp_path / "missing").read_text()


@pytest.mark.parametrize("swallows", [False, True])
def test_signals_pass_through(swallows: bool, stranger: ModuleType) -> None:
    def interrupted() -> None:
        try:
            signal.raise_signal(signal.SIGINT)
        except BaseException:
            if swallows:
                sys.exit(0)
            raise

    kind = SystemExit if swallows else KeyboardInterrupt
    with pytest.raises(kind), ForeignCode("the plug-in 'x'"):
        stranger.call(interrupted)


def test_the_import_path_and_the_working_folder_are_restored(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    path = list(sys.path)
    with suppress(InputError), ForeignCode("x"):
        sys.path.clear()
        os.chdir("/")
        raise Odd
    assert (sys.path, Path.cwd()) == (path, tmp_path)
    with ForeignCode("x"):
        sys.path.insert(0, "mine")
    assert sys.path == [*path, "mine"]
    sys.path.remove("mine")


def test_messages_are_one_line() -> None:
    assert summarize_error(ValueError("a\n  b")) == "ValueError: a b"
    assert summarize_error(SystemExit()) == "SystemExit"
    assert summarize_error(MuteError()) == "MuteError"
