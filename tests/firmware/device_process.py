"""Running program of a device."""

import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO

import numpy as np
from numpy.typing import NDArray

from firstcontact.core.layout import ADC_COUNTS


def random_scans(n: int, seed: int) -> NDArray[np.uint16]:
    """Return readings over the converter's whole range, shape (n, 6)."""
    scans = np.random.default_rng(seed).integers(0, ADC_COUNTS, (n, 6), dtype=np.uint16)
    scans[:, 4:] &= 1
    return scans


class Running:
    """Running program that serves the pseudo terminal ``path``. Pass scans with :meth:`feed`."""

    def __init__(self, path: str, process: subprocess.Popen[bytes]) -> None:
        self.path = path
        self.process = process

    def feed(self, scans: NDArray[np.uint16]) -> None:
        """Write scans to the program. Return when the pipe has taken all of them."""
        stream: IO[bytes] | None = self.process.stdin
        stream.write(scans.tobytes())
        stream.flush()


@contextmanager
def running(program: Path, *options: str) -> Iterator[Running]:
    """Start the program and end it. Without ``--scans`` a pipe feeds it."""
    if "--scans" not in options:
        options = ("--scans", "-", *options)
    with subprocess.Popen(
        [program, *options],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        bufsize=0,
    ) as process:
        try:
            path = process.stdout.readline().decode().strip()
            assert path, process.stderr.read().decode()
            yield Running(path, process)
            died = process.poll()
            assert died is None, process.stderr.read().decode()
        finally:
            process.terminate()
