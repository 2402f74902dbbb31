"""Command ``firstcontact info``: versions and ports, or the descriptor of a device."""

from __future__ import annotations

import platform
import re
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, requires, version
from pathlib import Path
from typing import Annotated

from firstcontact.cli.options import Condition, devices
from firstcontact.cli.verbs.ports import port_lines

#: Time for which a device is read, s.
LISTEN = 2.0


@dataclass(frozen=True)
class Info:
    """Print versions and ports for a bug report, or the descriptor of a device."""

    device: Annotated[
        str | None, devices(more=" Prints its description, and counts its samples for 2 s.")
    ] = None
    """A device to describe."""
    condition: Condition = "paper-rig"
    """Variation between pinches, as in the paper's set-up or everyday use."""

    def run(self) -> None:
        if self.device is not None:
            for line in _device(self.device, self.condition):
                print(line)
            return
        for line in (*_software(), *port_lines()):
            print(line)


def _software() -> Iterator[str]:
    yield _line("firstcontact", version("firstcontact"))
    yield _line("Python", f"{platform.python_version()} ({sys.executable})")
    yield _line("platform", platform.platform())
    for name in _required_packages():
        try:
            yield _line(name, version(name))
        except PackageNotFoundError:
            yield _line(name, "not installed")


def _required_packages() -> list[str]:
    """Return the packages that this package and its extras require, except the extra ``dev``."""
    # "matplotlib>=3.9; extra == 'plot'"
    needs = (need for need in requires("firstcontact") or [] if "dev" not in need.partition(";")[2])
    names = (re.split(r"[^\w.-]", need)[0] for need in needs)
    return [name for name in dict.fromkeys(names) if name != "firstcontact"]


def _device(name: str, condition: str) -> Iterator[str]:
    from firstcontact.collect.calibration import is_tapped
    from firstcontact.device import open_source
    from firstcontact.device.opening import source_kind
    from firstcontact.device.ports import access
    from firstcontact.device.source import clock_line

    source = open_source(name, condition=condition)
    if source_kind(name).is_port:
        yield _line("port", access(Path(name)))
    with source:
        descriptor, layout = source.descriptor, source.descriptor.layout
        yield _line("device", name)
        for field in ("firmware", "sensor", "hand", "source"):
            if field != "hand" or descriptor.hand or not is_tapped(layout):
                yield _line(field, getattr(descriptor, field) or "not known")
        yield _line("rate", f"{layout.rate:g} Hz, {layout.smoothing}")
        names = ", ".join(layout.column_names)
        if descriptor.delay:
            yield _line("", f"its own filter delays samples by {1e3 * descriptor.delay:.2f} ms")
        yield _line("channels", f"{layout.width} ({descriptor.dtype}): {names}")
        until = time.monotonic() + LISTEN
        while (left := until - time.monotonic()) > 0 and not source.ended:
            source.read(left)
    health = source.health
    yield _line("samples", f"{health.samples}, and {health.lost} lost")
    yield _line("", f"of these {health.overflow_samples} dropped by the device")
    if health.unusable_samples:
        yield _line("", f"of these {health.unusable_text}")
    yield _line(
        "frames",
        f"{health.bad_frames} damaged, {health.lost_frames} lost, {health.doubled_frames} doubled",
    )
    yield _line("epochs", str(health.reconnects + 1))
    if clock := clock_line(health, layout.rate):
        yield _line("", clock)


def _line(name: str, text: str) -> str:
    return f"{name:16} {text}"
