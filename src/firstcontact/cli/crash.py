"""What nobody foresaw: one sentence, and a log to report it with."""

from __future__ import annotations

import os
import platform
import shlex
import tempfile
import traceback
from collections.abc import Sequence
from datetime import UTC, datetime
from pathlib import Path

from firstcontact import __version__
from firstcontact.cli.logs import kept
from firstcontact.core import one_line, plain

#: Options whose values are secrets.
SECRET = ("--token",)


def told(error: BaseException, arguments: Sequence[str]) -> str:
    """Write the log; the sentence that says what happened and where the log is."""
    what = one_line(f"{type(error).__name__}: {error}".removesuffix(": "))
    cause = "memory ran out" if isinstance(error, MemoryError) else "something went wrong that"
    cause += "" if isinstance(error, MemoryError) else " nobody foresaw"
    path = _write(_text(error, arguments))
    if path is None:
        return f"{cause} ({what}), and no log of it could be written: report this line"
    return f"{cause} ({what}): please report it, with {path}"


def _text(error: BaseException, arguments: Sequence[str]) -> str:
    command, secrets = _redacted(arguments)
    lines = [
        "Please report this together with what you did; `firstcontact info` says more about your",
        "machine. Read it first: it holds paths and names of yours.",
        "",
        f"firstcontact {__version__}",
        f"Python {platform.python_version()}, {platform.platform()}",
        f"at {datetime.now(UTC).isoformat(timespec='seconds')}",
        f"command: {command}",
        "",
    ]
    text = "\n".join(lines) + "\n" + "".join(traceback.format_exception(error))
    if kept():
        text += "\n".join(["", "What it logged last:", "", *kept(), ""])
    for secret in secrets:
        text = text.replace(secret, "***")
    return plain(text)


def _redacted(arguments: Sequence[str]) -> tuple[str, list[str]]:
    """The command line without its secrets, and these."""
    words, secrets = [], []
    hide = False
    for word in arguments:
        name, equals, value = word.partition("=")
        if hide and word:
            secrets.append(word)
            word = "***"
        elif name.replace("_", "-") in SECRET and value:
            secrets.append(value)
            word = f"{name}=***"
        hide = word.replace("_", "-") in SECRET and not equals
        words.append(word)
    return shlex.join(["firstcontact", *words]), secrets


def _write(text: str) -> Path | None:
    """Into the folder of programs' states, or that of temporary files; None if neither works."""
    name = f"firstcontact-{datetime.now(UTC):%Y%m%dT%H%M%S.%fZ}-{os.getpid()}.log"
    for folder in (_state, lambda: Path(tempfile.gettempdir())):
        try:
            place = folder()
            place.mkdir(parents=True, exist_ok=True)
            path = place / name
            # Nobody else's to read, and not through a link that somebody else has laid.
            number = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
            with os.fdopen(number, "w", encoding="utf-8") as stream:
                stream.write(text)
        except (OSError, RuntimeError):  # RuntimeError: there is no home
            continue
        return path
    return None


def _state() -> Path:
    given = os.environ.get("XDG_STATE_HOME", "")
    home = Path(given) if os.path.isabs(given) else Path.home() / ".local" / "state"  # noqa: PTH117
    return home / "firstcontact"
