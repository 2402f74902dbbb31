"""Self-test of new fingertips, which asks a person for taps and presses, and writes a page."""

from __future__ import annotations

from collections.abc import Iterator
from datetime import UTC, datetime
from html import escape
from pathlib import Path

import numpy as np

from firstcontact import __version__
from firstcontact.collect._self_test import (
    BEFORE,
    REMEDIES,
    Measured,
    Tap,
    Verdict,
    Volts,
    find_taps,
    has_array_faults,
    judge,
)
from firstcontact.collect.calibration import Say, is_tapped, rest_request
from firstcontact.core import ArgumentError, ChannelKind, DeviceError, Finger, finger_name
from firstcontact.core.display import BLUE, ORANGE
from firstcontact.core.files import write_text
from firstcontact.device import Descriptor, Source
from firstcontact.device.clock import TransportDelay
from firstcontact.device.noise_floor import wait_for_arrivals
from firstcontact.device.source import LinkNews, require_source
from firstcontact.device.twin_words import is_accepted, tester_text

#: Time at rest, s; whole periods of 50 and 60 Hz.
REST = 5.0
#: Good taps wanted on each finger, most of all with the others, and longest wait, s.
TAPS, MOST_TAPS = 5, 10
#: Number of corners of a pad, each of which is tapped once.
CORNERS = 4
PATIENCE = 20.0
#: Least peak of a good tap, V: its decay is then clear of the noise.
CLEAR = 0.3
#: Number of soft taps, more than half of all, from which on harder ones are asked for; fewer leave
#: enough good ones. Most requests.
SOFT_TAPS, REQUESTS = 3, 3
#: Time for the six places of a pad, s, and how often they are pressed again before a verdict.
PRESSES = 15.0
PRESSED_AGAIN = 2
#: Shortest and longest time for the drift, s.
DRIFT_SECONDS = (10.0, 3600.0)
#: Longest wait for the answer of simulated fingertips, s.
ANSWER = 2.0
#: Length of the pieces in which samples are processed, s.
PIECE = 0.25


def check_fingertips(
    source: Source, *, drift: float = 30.0, say: Say = lambda line: None
) -> tuple[Measured, list[Verdict]]:
    """Guide a person through the self-test of two fingertips. Return measurements and verdicts.

    The simulated hand taps and presses by itself. ``drift`` is the time for which the drift is
    measured, s; 0 skips this step. ``say`` is called with each line for the person.
    """
    require_source(source)
    shortest, longest = DRIFT_SECONDS
    if drift and not shortest <= drift <= longest:
        raise ArgumentError(
            f"the time for the drift is {drift:g} s: give 0, or {shortest:g} to {longest:g} s",
            parameter="drift",
        )
    layout = source.descriptor.layout
    if is_tapped(layout):
        raise DeviceError(f"{source.name} has no fingertips to check: give the device of a hand")
    if source.twin_hand is not None:
        say("simulated fingertips with varied parts: `calibrate` measures another pair")
    steps = _Steps(source, say)
    rest = steps.samples(f"{REST:g} s of rest: {rest_request(layout)}", "rest", REST)
    measured = Measured(layout, rest)
    vibration = layout.columns(ChannelKind.VIBRATION)
    fingers = [f for f in layout.vibration_fingers if f is not None]
    for finger in fingers:
        measured.taps[finger] = steps.taps(finger, rest[:, vibration])
        measured.corners[finger] = steps.corner_taps(finger, rest[:, vibration])
    for finger in fingers:
        if layout.columns(ChannelKind.FORCE, finger):
            measured.presses[finger] = steps.presses(finger)
            for _ in range(PRESSED_AGAIN):  # perhaps a place was forgotten
                if not has_array_faults(measured, finger):
                    break
                again = steps.presses(finger, "once more: ")
                measured.presses[finger] = np.concatenate([measured.presses[finger], again])
    if drift:
        request = f"{drift:g} s of drift: {rest_request(layout)}"
        seconds = list(steps.pieces(request, "rest", drift, 1.0))
        measured.drift = np.array([x[:, vibration].mean(axis=0) for x in seconds])
    if source.speed == 1.0 and not source.is_replay:
        measured.delays = np.concatenate(steps.delays)
    else:
        say("jitter is not measured: the samples must arrive in real time (speed 1)")
    measured.lost = source.health.lost_samples
    measured.samples = source.health.samples
    return measured, judge(measured)


class _Steps:
    """Steps of the self-test. Each method asks the person for an action, and returns samples.

    Samples have all columns of the layout, in physical units, shape (samples, columns).
    """

    def __init__(self, source: Source, say: Say) -> None:
        self._source, self._say = source, say
        self._layout = source.descriptor.layout
        self._link = LinkNews(source.health)
        self._transport = TransportDelay(self._layout.rate)
        self.delays: list[Volts] = []

    def pieces(self, request: str, task: str, seconds: float, piece: float) -> Iterator[Volts]:
        """Show a request to the person. Yield the samples of the next ``seconds`` s in pieces.

        A piece lasts ``piece`` s. ``task`` is the same request, as a simulated person reads it.
        """
        self._say(request)
        self._order(task)
        length = round(piece * self._layout.rate)
        waiting = np.zeros((0, self._layout.width))
        for _ in range(round(seconds / piece)):
            while len(waiting) < length:
                waiting = np.concatenate([waiting, *self._next_samples()])
            yield waiting[:length]
            waiting = waiting[length:]

    def samples(self, request: str, task: str, seconds: float) -> Volts:
        """Show the ``request`` to the person. Return the samples of the next ``seconds`` s.

        ``task`` is the same request, as a simulated person reads it.
        """
        return np.concatenate(list(self.pieces(request, task, seconds, PIECE)))

    def presses(self, finger: Finger, start: str = "") -> Volts:
        """Ask the person to press all six places of a finger. Return the samples of this time.

        ``start`` is a text before the request.
        """
        name = finger_name(finger)
        request = f"{start}press the {name}'s six places in turn, each for a second, within "
        return self.samples(f"{request}{PRESSES:g} s", f"press {name}", PRESSES)

    def taps(self, finger: Finger, rest: Volts) -> list[Tap]:
        """Ask the person for taps on a finger. Return the detected taps.

        ``rest`` are samples of the vibration columns at rest, V.
        """
        name = finger_name(finger)
        request = (
            f"tap the middle of the {name}'s pad {TAPS} times with a pencil's blunt end, as if it "
            "fell 2 mm"
        )
        columns = self._layout.columns(ChannelKind.VIBRATION)
        x, taps = np.zeros((0, len(columns))), list[Tap]()
        clipped = soft = 0
        for piece in self.pieces(request, f"tap {name}", PATIENCE, PIECE):
            x = np.concatenate([x, piece[:, columns]])
            taps = find_taps(self._layout, x, rest)
            clipped_before, clipped = clipped, sum(t.is_clipped for t in taps)
            soft_before, soft = soft, sum(np.abs(t.volts).max() < CLEAR for t in taps)
            if len(taps) - clipped - soft >= TAPS or len(taps) >= MOST_TAPS:
                break
            if clipped > clipped_before:
                self._say("too hard: tap more gently")
                self._order("gentler")
            elif soft > soft_before and 2 * soft > len(taps) and 0 <= soft - SOFT_TAPS < REQUESTS:
                self._say("too soft: tap a little harder")
                self._order("harder")
        return taps

    def corner_taps(self, finger: Finger, rest: Volts) -> list[Tap]:
        """Ask the person for a tap on each corner of a finger's pad. Return the detected taps.

        ``rest`` are samples of the vibration columns at rest, V.
        """
        name = finger_name(finger)
        columns = self._layout.columns(ChannelKind.VIBRATION)
        x, taps = np.zeros((0, len(columns))), list[Tap]()
        request = f"tap each of the {CORNERS} corners of the {name}'s pad once, as before"
        for piece in self.pieces(request, f"tap {name} corners", PATIENCE, PIECE):
            x = np.concatenate([x, piece[:, columns]])
            taps = find_taps(self._layout, x, rest)
            if len(taps) >= CORNERS:
                break
        return taps

    def _order(self, task: str) -> None:
        """Drop all samples so far. Send the task to a simulated person, and await the answer."""
        self._source.order(tester_text(task))
        self._source.read(0)
        if self._source.twin_hand is None:
            return
        end = self._source.health.samples + ANSWER * self._layout.rate
        while self._source.health.samples < end:
            for arrival in wait_for_arrivals(self._source):
                if any(is_accepted(m.text, tester_text(task)) for m in arrival.markers):
                    return

    def _next_samples(self) -> list[Volts]:
        """Return the next samples in physical units. Append their delays, s, to ``self.delays``."""
        raw = []
        for arrival in wait_for_arrivals(self._source):
            block = arrival.block
            if not len(block.data):
                continue
            self._transport.add(block, arrival.host)
            last = self._transport.delay(block.end - 1, arrival.host)
            self.delays.append(last + np.arange(len(block.data))[::-1] / self._layout.rate)
            raw.append(block.data)
        for line in self._link.lines(self._source.health):
            self._say(line)
        columns = tuple(range(self._layout.width))
        return [self._layout.physical(x, columns) for x in raw]


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
    """Write the result of a self-test as an HTML page. The finished file replaces an old one."""
    title = descriptor.sensor or "fingertips"
    date = datetime.now(UTC).isoformat(" ", "minutes").removesuffix("+00:00")
    facts = [title, descriptor.hand, descriptor.firmware, f"{date} UTC"]
    facts.append(f"{measured.layout.rate:g} samples per second; firstcontact {__version__}")
    faults, rows, order = [], [], list(REMEDIES)
    for v in sorted(verdicts, key=lambda v: order.index(v.check)):
        state = "good" if v.is_good else "fault"
        columns = "".join(f"<td>{escape(cell)}</td>" for cell in (*v[:4], state))
        rows.append(f'<tr class="{state}">{columns}</tr>')
        if not v.is_good:
            name = escape(f"{v.check} {v.finger}".strip())
            faults.append(f"<li><b>{name}</b>: {escape(v.remedy)}</li>")
    page = _PAGE.format(
        title=escape(title),
        summary=escape(summary(verdicts)),
        facts=escape("; ".join(fact for fact in facts if fact)),
        faults="".join(faults),
        rows="\n".join(rows),
        figures="\n".join(
            _tap_figure(f, measured, t[0].volts) for f, t in measured.taps.items() if t
        ),
    )
    write_text(path, page)


def summary(verdicts: list[Verdict]) -> str:
    """Return a sentence with the number of checks that found a fault."""
    count = sum(not v.is_good for v in verdicts)
    return f"{count} of {len(verdicts)} checks found a fault" if count else "no fault was found"


def _tap_figure(finger: Finger, measured: Measured, volts: Volts) -> str:
    """Return an HTML figure of a tap on ``finger``, from 7 ms before it to 33 ms after it.

    ``volts`` is the tap in all vibration channels, V, shape (samples, channels).
    """
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
        f"<figure><figcaption>A tap on the {finger_name(finger)}</figcaption>"
        '<svg width="400" height="180" style="border: 1px solid #D5DBE1">'
        f'<path d="M0 90H400" stroke="#D5DBE1"/>{"".join(parts)}</svg></figure>'
    )
