"""Start of a child process that ends with its parent.

``python -m firstcontact.core._die_with_parent PARENT SIGNAL MODULE OPTIONS`` first asks the kernel
for a signal when the parent ends. It then runs the module in the same process.
"""

from __future__ import annotations

import os
import runpy
import signal
import sys
import threading
import time

#: Poll interval for the parent, s, on systems whose kernel sends no signal.
POLL_INTERVAL = 0.5


def follow(parent: int, number: signal.Signals = signal.SIGKILL) -> None:
    """Send this process a signal when its parent ends."""
    if not _request_parent_signal(number):
        threading.Thread(
            target=_poll_parent, args=(parent, number), name="parent", daemon=True
        ).start()
    if os.getppid() != parent:
        os.kill(os.getpid(), number)


def _request_parent_signal(number: signal.Signals) -> bool:
    """Request the signal from the kernel. Return False if the kernel does not support it."""
    if sys.platform != "linux":
        return False
    import ctypes

    set_parent_death_signal = 1
    try:
        libc = ctypes.CDLL(None, use_errno=True)
        return bool(libc.prctl(set_parent_death_signal, int(number), 0, 0, 0) == 0)
    except (OSError, AttributeError):
        return False


def _poll_parent(parent: int, number: signal.Signals) -> None:
    while os.getppid() == parent:
        time.sleep(POLL_INTERVAL)
    os.kill(os.getpid(), number)


def main() -> None:
    """Run a module in this process, and end the process when its parent ends."""
    parent, number, module, *options = sys.argv[1:]
    follow(int(parent), signal.Signals(int(number)))
    sys.argv = [module, *options]
    runpy.run_module(module, run_name="__main__", alter_sys=True)


if __name__ == "__main__":
    main()
