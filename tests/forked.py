"""Programs in processes of their own, without the seconds that imports take.

A server process, one for each process that runs tests, imports once what commands need. It is
forked for each program, which then has its own number, working directory, environment and output.
"""

from __future__ import annotations

import multiprocessing
import os
import runpy
import subprocess
import sys
import tempfile
import warnings
from collections.abc import Mapping
from pathlib import Path
from typing import Any

#: Longest wait for a program, s: only a failing test waits so long.
LONG = 240.0
#: Slow imports that many commands share, but none that starts threads.
PRELOADED = (
    "firstcontact.cli.main",
    "firstcontact.cli.session_keys",
    "firstcontact.models",
    "firstcontact.recording",
    "firstcontact.streaming",
    "scipy.signal",
    "scipy.stats",
)

_SERVER = multiprocessing.get_context("forkserver")
_SERVER.set_forkserver_preload(list(PRELOADED))


def firstcontact(*words: object, **options: Any) -> subprocess.CompletedProcess[str]:
    """Run the command line, with the options of `run`."""
    return run("command", *words, **options)


def run(
    kind: str,
    *words: object,
    cwd: Path | None = None,
    environment: Mapping[str, str] | None = None,
    strict: bool = False,
) -> subprocess.CompletedProcess[str]:
    """Run a program to its end.

    Parameters
    ----------
    kind
        "command" for the command line, "script" for a file, "code" for a text of Python.
    *words
        Arguments, after the file or the text.
    cwd
        Working directory.
    environment
        Environment; that of this process by default.
    strict
        Turn warnings into errors.
    """
    command = [str(word) for word in words]
    with tempfile.TemporaryDirectory() as folder:
        streams = [str(Path(folder) / name) for name in ("stdout", "stderr")]
        arguments = (kind, command, cwd or Path.cwd(), dict(environment or os.environ))
        process = _SERVER.Process(target=_program, args=(*arguments, streams, strict))
        process.start()
        process.join(LONG)
        if process.exitcode is None:
            process.kill()
            process.join()
        texts = [Path(stream).read_text(encoding="utf-8") for stream in streams]
        return subprocess.CompletedProcess(command, process.exitcode or 0, *texts)


def _program(
    kind: str,
    words: list[str],
    cwd: Path,
    environment: dict[str, str],
    streams: list[str],
    strict: bool,
) -> None:
    os.chdir(cwd)
    os.environ.clear()
    os.environ.update(environment)
    sys.path[:0] = environment.get("PYTHONPATH", "").split(os.pathsep)
    for number, path in enumerate(["/dev/null", *streams]):
        made = os.open(path, os.O_RDWR | os.O_CREAT)
        os.dup2(made, number)
        os.close(made)
    sys.stdin = open(0, encoding="utf-8", closefd=False)  # noqa: SIM115
    sys.stdout = open(1, "w", encoding="utf-8", closefd=False)  # noqa: SIM115
    sys.stderr = open(2, "w", encoding="utf-8", closefd=False, buffering=1)  # noqa: SIM115
    if strict:
        warnings.simplefilter("error")
    if kind == "command":
        from firstcontact.cli.main import main

        sys.exit(main(words))
    sys.argv = words if kind == "script" else ["-c", *words[1:]]
    if kind == "script":
        sys.path.insert(0, str(Path(words[0]).parent))
        runpy.run_path(words[0], run_name="__main__")
    else:
        sys.path.insert(0, "")
        exec(compile(words[0], "<code>", "exec"), {"__name__": "__main__"})
