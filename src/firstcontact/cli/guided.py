"""Terminal output of a guided recording: lines, and a status line that is overwritten."""

from __future__ import annotations

import select
import sys

from firstcontact.cli.output import reader_gone
from firstcontact.cli.stopping import Stop
from firstcontact.collect.calibration import is_tapped
from firstcontact.collect.guide import Guide, Judged
from firstcontact.collect.session import Screen
from firstcontact.core import InputError, Label
from firstcontact.device import Source
from firstcontact.device.source import LinkNews

#: Time without a closing after which the terminal prints a reminder, s by the device's clock.
REMIND = 10.0
#: Noise, as a multiple of the noise floor, above which closings cannot be detected.
NOISY = 1.4


def entered() -> bool:
    """Return True if a person pressed Enter since the last call. This function does not wait."""
    try:
        if not select.select([sys.stdin], [], [], 0)[0]:
            return False
        line = sys.stdin.readline()
    except OSError:  # the terminal was closed
        line = ""
    if not line:
        raise InputError(
            "this step waits for Enter, but standard input has ended: run the command in a "
            "terminal, or leave out the steps that a person does"
        )
    return True


class Terminal(Screen):
    """Display of a guided recording in a terminal.

    The person presses Enter after each new object.
    """

    def __init__(self, source: Source, stop: Stop, asks: bool) -> None:
        self.complete = True
        self._source = source
        self._stop = stop
        self._asks = asks
        self._guide: Guide | None = None
        self._live = sys.stdout.isatty()
        self._width = 0
        self._reminded_at = 0
        self._link = LinkNews(source.health)
        self._lost_before = 0

    def say(self, line: str) -> None:
        start = "\r" if self._live else ""
        print(start + line.ljust(self._width), flush=True)

    def begin(self, guide: Guide) -> None:
        """Begin to show the recording. ``guide`` names the objects and judges the closings."""
        health = self._source.health
        self._guide = guide
        self._asks = self._asks and guide.objects > 1
        self._reminded_at = health.samples
        self._link = LinkNews(health)
        self._lost_before = health.lost_samples
        self.complete = False
        self._stop.gently = True

    def end(self) -> None:
        self._stop.gently = False
        guide, health = self._following(), self._source.health
        self.complete = guide.current is None
        for line in self._link.lines(health, last=True):
            self.say(line)
        self.say(
            f"{health.link}; {guide.left_out} "
            f"{'taps' if is_tapped(guide.layout) else 'closings'} did not count"
        )
        lost = health.lost_samples - self._lost_before
        if lost:
            self.say(
                f"warning: the recording has gaps, {lost} samples are missing from it; a pinch "
                "with a gap does not count and is recorded again"
            )

    def next_object(self, label: Label, recorded: int, wanted: int) -> bool:
        level = f", {label.value_words}" if label.value else ""
        self._say_and_reset_timer(
            f"next: {label.object}{level}, specimen {label.specimen}, "
            f"{wanted - recorded} of {wanted} pinches to go"
            + (": put it in place and press Enter" if self._asks else "")
        )
        if self._asks and reader_gone():
            raise InputError(
                "standard output is closed, so nobody can read the next step: use a terminal, or "
                "record one object at a time"
            )
        return not self._asks

    def object_is_placed(self) -> bool:
        return entered()

    def judged(self, judged: Judged) -> None:
        name = judged.label.object
        if judged.faults:
            self._say_and_reset_timer(f"{name}: does not count: {'; '.join(judged.faults)}")
            return
        parts = [f"{name} {judged.k}/{judged.wanted}: contact"]
        if judged.disagreement is not None:
            parts.append(f"strip and piezo agree to {abs(judged.disagreement) * 1e3:.1f} ms")
        if judged.offset is not None:
            parts.append(f"offset {judged.offset * 1e3:.1f} ms")
        parts.append(f"noise {judged.noise:.2f} x floor")
        parts.append(f"{self._source.health.lost_samples} samples lost so far")
        self._say_and_reset_timer(", ".join(parts))

    def going_on(self) -> None:
        health, guide = self._source.health, self._following()
        for line in self._link.lines(health):
            self.say(line)
        waited = (health.samples - self._reminded_at) / guide.layout.rate
        noise = f"noise {guide.noise:.2f} x floor"
        if waited >= REMIND and not guide.paused:
            event, place = "the hand to close", "hand"
            if is_tapped(guide.layout):
                event, place = "a tap", "surroundings"
            advice = f": calibrate again, or quieten the {place}" if guide.noise > NOISY else ""
            self._say_and_reset_timer(f"waiting for {event}; {noise}{advice}")
        if self._live:
            line = (
                f"{health.samples / guide.layout.rate:.0f} s, {noise}, {health.lost_samples} lost"
            )
            self._width = max(self._width, len(line))
            print(f"\r{line.ljust(self._width)}", end="", flush=True)

    def _say_and_reset_timer(self, line: str) -> None:
        self.say(line)
        self._reminded_at = self._source.health.samples

    def _following(self) -> Guide:
        assert self._guide is not None, "begin comes first"
        return self._guide
