"""Child processes by a fork, which saves the time that a new interpreter takes to load.

`firstcontact.jobs.Child` starts the process of a twin. Here it is forked from the test process.
Programs that tests start with ``sys.executable`` start it as for users.
"""

import gc
import os
import signal
import subprocess
import sys
import traceback
import warnings
from collections.abc import Sequence
from functools import cache
from itertools import pairwise
from types import SimpleNamespace
from typing import Any

from firstcontact.jobs import children

#: Module of the process that is forked.
TWIN = "firstcontact.device.twin_process"


@cache
def load() -> None:
    """Import what the twin's process needs, and load its compiled functions."""
    from firstcontact.device import twin_process
    from firstcontact.twin import TwinStream
    from firstcontact.twin.sensor import DeviceFilter

    DeviceFilter().update(TwinStream(seed=0).read(twin_process.FRAME_SAMPLES))


def fork_children() -> None:
    """Fork the twins that this process starts from now on."""
    forking = SimpleNamespace(Popen=_start, PIPE=subprocess.PIPE, DEVNULL=subprocess.DEVNULL)
    children.subprocess = forking  # type: ignore[attr-defined]


def _start(words: list[str], **options: Any) -> subprocess.Popen[bytes]:
    if TWIN not in words:
        return subprocess.Popen(words, **options)
    load()
    return _Fork(words, **options)


class _Fork(subprocess.Popen[bytes]):
    """Process that is forked from this one, with other streams and in another session."""

    def _execute_child(  # type: ignore[no-untyped-def]
        self, args, executable, preexec_fn, close_fds, pass_fds, cwd, env, startupinfo,
        creationflags, shell, p2cread, p2cwrite, c2pread, c2pwrite, errread, errwrite, *_,
    ):  # fmt: skip
        with warnings.catch_warnings():
            # Other threads hold no lock that the child takes. Python 3.12 warns of them.
            warnings.simplefilter("ignore", DeprecationWarning)
            sys.stdout.flush()  # or the child writes what this process has printed, too
            self.pid = os.fork()
        if self.pid == 0:
            _run(args[args.index("-m") + 2 :], pass_fds, p2cread, c2pwrite)
        self._child_created = True
        self._close_pipe_fds(p2cread, p2cwrite, c2pread, c2pwrite, errread, errwrite)


def _run(words: list[str], passed: Sequence[int], *streams: int) -> None:
    code = 1
    try:
        # Nothing of the other process may be finalised here: its descriptors have other meanings.
        gc.freeze()
        os.setsid()
        for number, stream in enumerate(streams):
            if stream >= 0:
                os.dup2(stream, number)
        for low, high in pairwise([2, *sorted(passed), os.sysconf("SC_OPEN_MAX")]):
            os.closerange(low + 1, high)
        signal.set_wakeup_fd(-1)
        for number in signal.valid_signals():
            if callable(signal.getsignal(number)):
                signal.signal(number, signal.SIG_DFL)
        sys.stdin = open(0, encoding="utf-8", closefd=False)  # noqa: SIM115
        sys.stdout = open(1, "w", encoding="utf-8", closefd=False)  # noqa: SIM115
        sys.stderr = open(2, "w", 1, encoding="utf-8", closefd=False)  # noqa: SIM115
        warnings.resetwarnings()
        warnings.simplefilter("ignore", DeprecationWarning)
        sys.modules.pop(words[2], None)
        sys.argv = ["-m", *words]
        children.main()
        code = 0
    except SystemExit as leaving:
        code = int(leaving.code or 0)
    except BaseException:
        traceback.print_exc()
    finally:
        os._exit(code)
