"""A bound on the memory that a library may take for a file that lies to it."""

from __future__ import annotations

import resource
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

_STATUS = Path("/proc/self/status")


@contextmanager
def bounded_memory(more: int) -> Iterator[None]:
    """Have allocations fail that would take the process this many bytes further than it is.

    A library that allocates what a damaged file asks for then says that it cannot. It
    holds for the whole process. Where the system does not tell how much there is, nothing
    is bounded.
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
    """Bytes of data that the process has, as the limit counts them."""
    try:
        lines = _STATUS.read_text().splitlines()
    except OSError:
        return None
    fields = dict(line.split(":", 1) for line in lines)
    return int(fields["VmData"].split()[0]) * 1024 if "VmData" in fields else None
