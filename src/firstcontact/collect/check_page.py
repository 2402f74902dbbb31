"""Page of a self-test: one HTML file without links to others."""

from __future__ import annotations

from collections.abc import Iterator
from datetime import UTC, datetime
from html import escape
from pathlib import Path

import numpy as np

from firstcontact import __version__
from firstcontact.collect._self_test import REMEDIES, Measured, Verdict
from firstcontact.collect._taps import BEFORE, Volts
from firstcontact.core import finger_name
from firstcontact.core.display import BLUE, ORANGE
from firstcontact.core.files import write_text
from firstcontact.device import Descriptor

_PAGE = """<!DOCTYPE html>
<html lang="en"><meta charset="utf-8"><title>Self-test of {title}</title>
<style>
body {{ font: 15px/1.5 sans-serif; color: #1F2933; max-width: 56em; margin: 2em auto }}
table {{ border-collapse: collapse; margin: 1em 0 }}
td, th {{ border-bottom: 1px solid #D5DBE1; padding: .25em .8em; text-align: left }}
.fault {{ background: #FDECE4 }}
figure {{ display: inline-block; margin: .5em 1em .5em 0 }}
text {{ font-size: 13px }}
</style>
<h1>{summary}</h1>
<p>{facts}</p>
<ul>{faults}</ul>
<table><tr><th>check<th>finger<th>measured<th>limit<th>verdict</tr>
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
    order = list(REMEDIES)
    page = _PAGE.format(
        title=escape(title),
        summary=escape(summary(verdicts)),
        facts=escape("; ".join(fact for fact in facts if fact)),
        faults="".join(_fault(v) for v in verdicts if not v.is_good),
        rows="\n".join(map(_row, sorted(verdicts, key=lambda v: order.index(v.check)))),
        figures="\n".join(_figures(measured)),
    )
    write_text(path, page)


def summary(verdicts: list[Verdict]) -> str:
    """Return a sentence with the number of faults."""
    count = sum(not v.is_good for v in verdicts)
    return f"{count} of {len(verdicts)} checks found a fault" if count else "no fault was found"


def _fault(verdict: Verdict) -> str:
    name = escape(f"{verdict.check} {verdict.finger}".strip())
    return f"<li><b>{name}</b>: {escape(verdict.remedy)}</li>"


def _row(verdict: Verdict) -> str:
    state = "good" if verdict.is_good else "fault"
    columns = "".join(f"<td>{escape(cell)}</td>" for cell in (*verdict[:4], state))
    return f'<tr class="{state}">{columns}</tr>'


def _figures(measured: Measured) -> Iterator[str]:
    """Yield one drawing for each tapped finger: its first tap in both sensors."""
    for finger, taps in measured.taps.items():
        if taps:
            yield _drawing(f"A tap on the {finger_name(finger)}", measured, taps[0].volts)


def _drawing(title: str, measured: Measured, volts: Volts) -> str:
    """Draw a tap, 10 pixels a millisecond, from 7 ms before its begin to 33 ms after it."""
    height = 1.1 * float(np.abs(volts).max())
    times = 1e3 * (np.arange(len(volts)) / measured.layout.rate - BEFORE)
    shown = np.abs(times - 13) <= 20
    parts = [f'<text x="4" y="15">+{height:.2f} V</text><text x="4" y="172">-{height:.2f} V</text>']
    parts += [
        f'<path d="M{70 + 10 * t} 0v180" stroke="#D5DBE1"/>'
        f'<text x="{73 + 10 * t}" y="172">{t} ms</text>'
        for t in (0, 10, 20)
    ]
    for k, channel in enumerate(measured.layout.vibration):
        places = zip(70 + 10 * times[shown], 90 - 90 * volts[shown, k] / height, strict=True)
        points = " ".join(f"{x:.1f},{y:.1f}" for x, y in places)
        colour = (BLUE, ORANGE)[k % 2]
        parts.append(
            f'<polyline fill="none" stroke="{colour}" stroke-width="1.5" points="{points}"/>'
            f'<text x="340" y="{20 + 16 * k}" fill="{colour}">'
            f"{escape(finger_name(channel.finger))}</text>"
        )
    return (
        f"<figure><figcaption>{escape(title)}</figcaption>"
        '<svg width="400" height="180" style="border: 1px solid #D5DBE1">'
        f'<path d="M0 90H400" stroke="#D5DBE1"/>{"".join(parts)}</svg></figure>'
    )
