"""Generated pair of C files, with its cost in memory and time."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class CUnit:
    """A pair of files.

    Parameters
    ----------
    name
        Of both, without their endings.
    header, source
        Their texts.
    constants, memory
        Bytes of constants and of static memory.
    instructions
        About how many one answer takes; 0 where that is not known.
    fixed
        Names of the files that are the same for all and that it needs, without their endings.
    rate
        Sampling rate that its lengths are of, Hz; None where its header does not depend on one.
    """

    name: str
    header: str
    source: str
    constants: int
    memory: int
    instructions: int
    fixed: tuple[str, ...]
    rate: float | None = None
