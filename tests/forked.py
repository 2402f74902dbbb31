"""Programs in forked processes, which saves the seconds that imports take.

One server process per test process imports the libraries of the commands once. For each program the
server is forked. The fork has its own process ID, working directory, environment and streams.
"""

import multiprocessing
import os
import runpy
import subprocess
import sys
import types
import warnings
from multiprocessing import forkserver
from multiprocessing.reduction import DupFd
from pathlib import Path
from pkgutil import resolve_name, walk_packages
from typing import Any

from forked_children import fork_children
from quick_training import train_quickly

#: Longest wait for a program, s: only a failing test waits so long.
LONG = 240.0
#: Modules with imports that few commands share, or that start threads.
_RARE = (
    ".cluster",
    ".windows.efficientnet",
    ".ability",
    ".pretraining",
    ".pretrain",
)
#: Slow imports that many commands share, but none that starts threads, and the loaded twin.
PRELOADED = [
    module.name
    for package in ("firstcontact", "firstcontact_lab")
    for module in walk_packages(resolve_name(package).__path__, f"{package}.")
    if not any(name in module.name for name in _RARE)
] + [
    "scipy.stats",
    "scipy.signal",
    "sklearn.svm",
    "sklearn.pipeline",
    "safetensors.numpy",
    "matplotlib.figure",
    "matplotlib.backends.backend_svg",
    "preloaded",
]

_SERVER = multiprocessing.get_context("forkserver")
_SERVER.set_forkserver_preload(PRELOADED)


class Program(subprocess.Popen[str]):
    """Program that runs in a forked process.

    Parameters
    ----------
    kind
        "command" for the command line, "script" for a file, "code" for a text of Python.
    *words
        Arguments, after the file or the text.
    strict
        True to turn warnings into errors.
    **options
        Streams, ``cwd``, ``env`` and ``start_new_session`` of ``subprocess.Popen``.
    """

    def __init__(self, kind: str, *words: object, strict: bool = False, **options: Any) -> None:
        self._kind, self._strict = kind, strict
        super().__init__([str(word) for word in words], text=True, **options)

    def _execute_child(  # type: ignore[no-untyped-def]
        self, args, executable, preexec_fn, close_fds, pass_fds, cwd, env, startupinfo,
        creationflags, shell, p2cread, p2cwrite, c2pread, c2pwrite, errread, errwrite,
        restore_signals, gid, gids, uid, umask, start_new_session, process_group,
    ):  # fmt: skip
        given = (p2cread, c2pwrite, errwrite)
        streams = [_Stream(number if fd == -1 else fd) for number, fd in enumerate(given)]
        place, environment = str(cwd or Path.cwd()), dict(os.environ if env is None else env)
        arguments = (self._kind, args, place, environment, streams, start_new_session, self._strict)
        self._process = _SERVER.Process(target=_program, args=arguments)
        _start_server()
        self._process.start()
        self.pid, self._child_created = self._process.pid, True
        self._close_pipe_fds(p2cread, p2cwrite, c2pread, c2pwrite, errread, errwrite)

    def _internal_poll(self, *_: Any, **__: Any) -> int | None:
        self.returncode = self._process.exitcode
        return self.returncode

    def _wait(self, timeout: float | None) -> int:
        self._process.join(timeout)
        if self.poll() is None:
            raise subprocess.TimeoutExpired(self.args, timeout or 0.0)
        return self.returncode


def _start_server() -> None:
    """Start the server unless it is running. It can import the modules of these tests."""
    path = os.environ.get("PYTHONPATH")
    os.environ["PYTHONPATH"] = os.pathsep.join(filter(None, [str(Path(__file__).parent), path]))
    try:
        forkserver.ensure_running()
    finally:
        if path is None:
            del os.environ["PYTHONPATH"]
        else:
            os.environ["PYTHONPATH"] = path


class _Stream:
    """Open file that is passed to the forked process."""

    def __init__(self, number: int) -> None:
        self._number = number

    def __reduce__(self) -> tuple[Any, ...]:
        return _arrived, (DupFd(self._number),)


def _arrived(descriptor: Any) -> int:
    return int(descriptor.detach())


def firstcontact(*words: object, **options: Any) -> subprocess.CompletedProcess[str]:
    """Run the command line with the options of `run`."""
    return run("command", *words, **options)


def run(kind: str, *words: object, **options: Any) -> subprocess.CompletedProcess[str]:
    """Run a program to its end with the options of `Program`."""
    pipes = {"stdin": subprocess.DEVNULL, "stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    with Program(kind, *words, **{**pipes, **options}) as program:
        try:
            texts = program.communicate(timeout=LONG)
        finally:
            program.kill()
    return subprocess.CompletedProcess(program.args, program.returncode, *texts)


def _program(
    kind: str,
    words: list[str],
    cwd: str,
    environment: dict[str, str],
    streams: list[int],
    start_new_session: bool,
    strict: bool,
) -> None:
    if start_new_session:
        os.setsid()
    os.chdir(cwd)
    os.environ.clear()
    os.environ.update(environment)
    sys.path[:0] = environment.get("PYTHONPATH", "").split(os.pathsep)
    for number, stream in enumerate(streams):
        os.dup2(stream, number)
    for stream in streams:
        os.close(stream)
    sys.stdin = open(0, encoding="utf-8", closefd=False)  # noqa: SIM115
    sys.stdout = open(1, "w", encoding="utf-8", closefd=False)  # noqa: SIM115
    sys.stderr = open(  # noqa: SIM115
        2, "w", 1, encoding="utf-8", errors="backslashreplace", closefd=False
    )
    fork_children()
    train_quickly()
    if strict:
        warnings.simplefilter("error")
    if kind == "command":
        from firstcontact.cli.main import main

        sys.argv = ["firstcontact", *words]
        sys.exit(main())
    sys.argv = words if kind == "script" else ["-c", *words[1:]]
    if kind == "script":
        sys.path.insert(0, str(Path(words[0]).parent))
        runpy.run_path(words[0], run_name="__main__")
    else:
        sys.path.insert(0, "")
        # Dataclasses look the names of their annotations up in the module of the class.
        module = sys.modules["__main__"] = types.ModuleType("__main__")
        exec(compile(words[0], "<code>", "exec"), module.__dict__)
