"""Memory limit for libraries that read damaged files."""

from __future__ import annotations

import resource
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

_STATUS = Path("/proc/self/status")


@contextmanager
def bounded_memory(more: int) -> Iterator[None]:
    """Limit the memory of the process to the current amount plus ``more`` bytes."""
    taken = _taken()
    soft, hard = resource.getrlimit(resource.RLIMIT_DATA)
    limits = [x for x in (soft, hard) if x != resource.RLIM_INFINITY]
    if taken is None:
        yield
        return
    resource.setrlimit(resource.RLIMIT_DATA, (min([taken + more, *limits]), hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_DATA, (soft, hard))


def _taken() -> int | None:
    """Return the memory of the process that counts for the limit, bytes."""
    try:
        lines = _STATUS.read_text().splitlines()
    except OSError:
        return None
    fields = dict(line.split(":", 1) for line in lines)
    return int(fields["VmData"].split()[0]) * 1024 if "VmData" in fields else None
