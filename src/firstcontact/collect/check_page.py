"""Page of a self-test: one HTML file without links to others."""

from __future__ import annotations

from datetime import UTC, datetime
from html import escape
from pathlib import Path

import numpy as np

from firstcontact import __version__
from firstcontact.collect._self_test import Measured, Verdict
from firstcontact.collect._taps import BEFORE, Volts, find_taps
from firstcontact.core import ChannelKind, finger_name
from firstcontact.core.display import BLUE, ORANGE
from firstcontact.core.files import write_text
from firstcontact.device import Descriptor

_PAGE = """<!DOCTYPE html>
<html lang="en"><meta charset="utf-8"><title>Self-test of {title}</title>
<style>
body {{ font: 15px/1.5 sans-serif; color: #1F2933; max-width: 62em; margin: 2em auto }}
table {{ border-collapse: collapse; margin: 1em 0 }}
td, th {{ border-bottom: 1px solid #D5DBE1; padding: .3em .8em; text-align: left }}
.fault td {{ background: #FDECE4 }}
figure {{ display: inline-block; margin: .5em 1em .5em 0 }}
</style>
<h1>{summary}</h1>
<p>{facts}</p>
<table>
<tr><th>check<th>finger<th>measured<th>limit<th>verdict<th>remedy</tr>
{rows}
</table>
{figures}
<p>Send this page with your question.</p>
</html>
"""


def write_page(
    path: Path, descriptor: Descriptor, measured: Measured, verdicts: list[Verdict]
) -> None:
    """Write the page of a self-test. The finished file replaces an existing one."""
    title = descriptor.sensor or "fingertips"
    date = datetime.now(UTC).isoformat(" ", "minutes").removesuffix("+00:00")
    facts = [title, descriptor.hand, descriptor.firmware, f"{date} UTC"]
    facts.append(f"{measured.layout.rate:g} samples per second; firstcontact {__version__}")
    page = _PAGE.format(
        title=escape(title),
        summary=escape(summary(verdicts)),
        facts=escape("; ".join(fact for fact in facts if fact)),
        rows="\n".join(map(_row, sorted(verdicts, key=lambda v: v.is_good))),
        figures="\n".join(_figures(measured)),
    )
    write_text(path, page)


def summary(verdicts: list[Verdict]) -> str:
    """Return a sentence with the number of faults."""
    count = sum(not v.is_good for v in verdicts)
    return f"{count} of {len(verdicts)} checks found a fault" if count else "no fault was found"


def _row(verdict: Verdict) -> str:
    state = ("fault", verdict.remedy) if not verdict.is_good else ("good", "")
    cells = [*verdict[:4], *state]
    columns = "".join(f"<td>{escape(cell)}</td>" for cell in cells)
    return f'<tr class="{state[0]}">{columns}</tr>'


def _figures(measured: Measured) -> list[str]:
    """Return one drawing for each tapped finger: its first tap in both sensors."""
    columns = measured.layout.columns(ChannelKind.VIBRATION)
    drawings = []
    for finger, x in measured.taps.items():
        taps = find_taps(measured.layout, x, measured.rest[:, columns])
        if taps:
            name = finger_name(finger)
            drawings.append(_drawing(f"a tap on the {name}", measured, taps[0].volts))
    return drawings


def _drawing(title: str, measured: Measured, volts: Volts) -> str:
    height = 1.1 * float(np.abs(volts).max())
    times = 1e3 * (np.arange(len(volts)) / measured.layout.rate - BEFORE)
    lines = []
    for k, channel in enumerate(measured.layout.vibration):
        places = zip(times * 5 + 100, 90 - 80 * volts[:, k] / height, strict=True)
        points = " ".join(f"{x:.1f},{y:.1f}" for x, y in places)
        colour = (BLUE, ORANGE)[k % 2]
        lines.append(f'<polyline fill="none" stroke="{colour}" points="{points}"/>')
        lines.append(
            f'<text x="330" y="{20 + 16 * k}" fill="{colour}">'
            f"{escape(finger_name(channel.finger))}</text>"
        )
    return (
        f"<figure><figcaption>{escape(title)}: 80 ms, &#177;{height:.2f} V</figcaption>"
        '<svg width="400" height="180" style="border: 1px solid #D5DBE1">'
        f'<path d="M0 90H400" stroke="#D5DBE1"/>{"".join(lines)}</svg></figure>'
    )
