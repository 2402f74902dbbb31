"""Helper that runs an LSL stream in another process."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Literal


@contextmanager
def sending(
    name: str,
    rate: float = 4936.0,
    jitter: float = 0.0,
    lose_at: int | Literal["line"] = 0,
    lose: int = 0,
) -> Iterator[subprocess.Popen[str]]:
    program = Path(__file__).with_name("lsl_outlet.py")
    words = [sys.executable, str(program), name, *map(str, (rate, jitter, lose_at, lose))]
    pipe = subprocess.PIPE
    with subprocess.Popen(words, stdin=pipe, stdout=pipe, text=True) as outlet:
        assert outlet.stdout is not None
        assert outlet.stdout.readline() == "ready\n"
        try:
            yield outlet
        finally:
            outlet.kill()
