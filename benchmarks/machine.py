"""Name of the machine that a benchmark ran on."""

from __future__ import annotations

import platform
import re
from contextlib import suppress
from pathlib import Path


def machine_name() -> str:
    """Return the name of the processor."""
    with suppress(OSError):
        match = re.search(r"^model name\s*: (.+)$", Path("/proc/cpuinfo").read_text(), re.MULTILINE)
        if match:
            return match[1]
    return platform.processor() or platform.machine()
