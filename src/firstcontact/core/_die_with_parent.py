"""What a child does so that it ends with its parent.

Run as ``python -m firstcontact.core._die_with_parent PARENT SIGNAL MODULE OPTIONS`` it first asks
for the signal when its parent is gone, then becomes the module.
"""

from __future__ import annotations

import os
import runpy
import signal
import sys
import threading
import time

#: Where the system does not tell that a parent is gone, it is looked for so often, s.
LOOK = 0.5


def follow(parent: int, number: signal.Signals = signal.SIGKILL) -> None:
    """Have this process get a signal when its parent is gone.

    Parameters
    ----------
    parent
        Its parent's number: that may be gone already.
    number
        SIGKILL, which ends even a process that hangs or is stopped; or another that ends or wakes
        it.
    """
    if not _asked(number):
        threading.Thread(target=_look, args=(parent, number), name="parent", daemon=True).start()
    if os.getppid() != parent:
        os.kill(os.getpid(), number)


def _asked(number: signal.Signals) -> bool:
    """Ask the kernel, whose word counts for a stopped process, too; False where that cannot be."""
    if sys.platform != "linux":
        return False
    import ctypes

    set_parent_death_signal = 1
    try:
        libc = ctypes.CDLL(None, use_errno=True)
        return bool(libc.prctl(set_parent_death_signal, int(number), 0, 0, 0) == 0)
    except (OSError, AttributeError):
        return False


def _look(parent: int, number: signal.Signals) -> None:
    while os.getppid() == parent:
        time.sleep(LOOK)
    os.kill(os.getpid(), number)


def main() -> None:
    """Be a child."""
    parent, number, module, *options = sys.argv[1:]
    follow(int(parent), signal.Signals(int(number)))
    sys.argv = [module, *options]
    runpy.run_module(module, run_name="__main__", alter_sys=True)


if __name__ == "__main__":
    main()
