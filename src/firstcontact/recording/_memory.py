"""Memory limit for a library that reads a damaged file."""

from __future__ import annotations

import resource
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

_STATUS = Path("/proc/self/status")


@contextmanager
def bounded_memory(more: int) -> Iterator[None]:
    """Limit allocations to the current memory of the process plus this many bytes.

    A library that trusts the sizes in a damaged file then reports an error. The limit applies to
    the whole process. There is none on systems that do not report the memory.
    """
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
    """Return the data size of the process, as the limit counts it, bytes."""
    try:
        lines = _STATUS.read_text().splitlines()
    except OSError:
        return None
    fields = dict(line.split(":", 1) for line in lines)
    return int(fields["VmData"].split()[0]) * 1024 if "VmData" in fields else None
