"""Command ``firstcontact inspect``: description of recordings, and a plot of a pinch."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from firstcontact.cli.options import Option
from firstcontact.core.text import counted

if TYPE_CHECKING:
    from firstcontact.core import Calibration, Dataset, Label, Layout
    from firstcontact.recording import PinchMark, Recording

#: Largest number of markers that are listed unasked.
FEW = 10


@dataclass(frozen=True)
class Inspect:
    """Describe a recording or a folder of recordings, and draw one pinch of a recording."""

    path: Annotated[Path, Option(positional=True)]
    """A recording, or a folder of recordings."""
    plot: Path | None = None
    """File for a drawing of one pinch: .png, .svg or .pdf."""
    pinch: int = 0
    """Number of the pinch to draw, from 0."""
    markers: bool = False
    """List every marker of a recording, even if there are many."""

    def run(self) -> None:
        from firstcontact.core import ArgumentError
        from firstcontact.recording import load_dataset, read_recording

        if self.path.is_dir():
            if self.plot is not None:
                raise ArgumentError(
                    f"--plot draws a pinch of one recording: name a file in {self.path}"
                )
            for line in _summary(load_dataset(self.path)):
                print(line)
            return
        recording = read_recording(self.path)
        for line in _lines(recording, self.markers):
            print(line)
        if self.plot is not None:
            self._plot(recording, self.plot)

    def _plot(self, recording: Recording, path: Path) -> None:
        from firstcontact.core import ArgumentError
        from firstcontact.core.installation import require_modules
        from firstcontact.recording.dataset import cut

        require_modules("plot", "matplotlib")
        from firstcontact.plots import plot_pinch

        if path.suffix.lower() not in (".png", ".svg", ".pdf"):
            raise ArgumentError(f"--plot {path} must end in .png, .svg or .pdf")
        mark = next((m for m in recording.pinches if m.number == self.pinch), None)
        pinch = cut(recording, mark) if mark else None
        if pinch is None:
            numbers = [m.number for m in recording.pinches]
            existing = f"{min(numbers)} to {max(numbers)}" if numbers else "none"
            raise ArgumentError(
                f"{self.path} holds no complete pinch {self.pinch} (existing: {existing}): "
                "choose another --pinch"
            )
        plot_pinch(pinch, f"Pinch {self.pinch}: {_label_words(pinch.label)}", path)
        print(f"drawn       {path}")


def _summary(data: Dataset) -> Iterator[str]:
    """Yield lines of text about a dataset: totals, the number of pinches per label, and notes."""
    from collections import Counter

    yield f"source      {data.source}"
    yield f"rate        {data.layout.rate:g} Hz, {data.layout.smoothing}"
    yield f"channels    {data.layout.width}: {', '.join(data.layout.column_names)}"
    yield f"sessions    {len(set(data.sessions.tolist()))}"
    yield f"pinches     {len(data)}, {sum(p.first is not None for p in data)} with known contacts"
    labels = Counter(replace(pinch.label, specimen="", session="") for pinch in data)
    for label, count in labels.items():
        yield f"  {count:4d}  {_label_words(label)}"
    for note in (*data.notes, *data.losses):
        yield f"note        {note}"


def _lines(recording: Recording, every_marker: bool) -> Iterator[str]:
    header, layout = recording.header, recording.header.layout
    yield f"recording   {recording.path}"
    yield f"source      {header.source}"
    for field in ("session", "sensor", "hand", "firmware", "created"):
        if value := getattr(header, field):
            assumed = field == "session" and header.session_assumed
            yield f"{field:11} {value}{' (assumed)' if assumed else ''}"
    for i, line in enumerate(header.notes.splitlines()):
        yield f"{'' if i else 'notes':11} {line}"
    yield from _calibration(header.calibration, layout)
    yield f"rate        {layout.rate:g} Hz, {layout.smoothing}"
    names = ", ".join(layout.column_names)
    yield f"channels    {layout.width} ({header.dtype}): {names}"
    for group in layout.groups:
        layout_of_group = group.layout
        count = sum(s.end - s.first_sample for s in recording.groups[group.name])
        width, samples = counted(layout_of_group.width, "channel"), counted(count, "sample")
        yield f"group       {group.name}: {width} at {layout_of_group.rate:g} Hz, {samples}"
    epochs = len({s.epoch for s in recording.stretches})
    yield (
        f"samples     {recording.samples} in {counted(len(recording.stretches), 'stretch')} of "
        f"{counted(epochs, 'epoch')}, {recording.duration:.3f} s"
    )
    is_long = len(recording.markers) > FEW and not every_marker
    if is_long:
        yield f"markers     {len(recording.markers)}: --markers lists them"
    for marker in () if is_long else recording.markers:
        yield f"marker      sample {marker.sample}: {marker.text}"
    yield f"pinches     {len(recording.pinches)}"
    for mark in recording.pinches:
        yield f"  {mark.number:4d}  {_label_words(mark.label)}; {_contact_words(mark, layout.rate)}"
    if not recording.skipped:
        yield "skipped     nothing"
    for sentence in recording.skipped:
        yield f"skipped     {sentence}"


def _calibration(calibration: Calibration | None, layout: Layout) -> Iterator[str]:
    from firstcontact.collect.calibration import measured_channel, rest_words, tap_words
    from firstcontact.core import finger_name

    if calibration is None:
        return
    yield f"calibration {calibration.created or 'of unknown date'}"
    for p in calibration.piezo:
        channel = measured_channel(layout, p)
        tap = "" if p.tap is None else f", {tap_words(p.tap, channel)}"
        kind = "vibration" if channel is None else channel.sensor
        yield f"  {finger_name(p.finger):6} {kind} {rest_words(p, channel)}{tap}"
    for f in calibration.force:
        yield (
            f"  {f.finger.name.lower():6} force leak {f.leak:.3g} S, gain {f.gain:.3g}, "
            f"exponent {f.exponent:.2f}, off by {f.rms:.2f} N RMS"
        )


def _label_words(label: Label) -> str:
    parts = [label.object or "unknown object", *filter(None, [label.value_words])]
    if label.specimen and label.specimen != label.object:
        parts.append(f"specimen {label.specimen}")
    if label.shape:
        parts.append(f"shape {label.shape}")
    return ", ".join([*parts, str(label.role)])


def _contact_words(mark: PinchMark, rate: float) -> str:
    from firstcontact.core import finger_name

    length = f"{(mark.end - mark.first_sample) / rate * 1e3:.1f} ms"
    if not mark.truth and mark.found:
        first = mark.found[0]
        at = (first.sample - mark.first_sample) / rate * 1e3
        return (
            f"{length}, {finger_name(first.finger)} at {at:.1f} ms as {mark.found_by} detected it, "
            "not confirmed"
        )
    if not mark.truth:
        return f"{length}, contacts not known"
    first = mark.truth[0]
    at = (first.sample - mark.first_sample) / rate * 1e3
    words = f"{length}, {finger_name(first.finger)} first at {at:.1f} ms"
    if len(mark.truth) > 1:
        words += f", offset {(mark.truth[1].sample - first.sample) / rate * 1e3:.2f} ms"
    return words
