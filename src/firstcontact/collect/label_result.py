"""Writer of labelled recordings: copies of recordings with the contacts that a person accepted."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from firstcontact.collect._label_marks import Mark, Status, measured
from firstcontact.core import Block, Contact, FileError, Label
from firstcontact.core.files import creating
from firstcontact.core.text import counted
from firstcontact.recording import Header, Marker, PinchMark, Recording, RecordingWriter
from firstcontact.recording.events import NO_CONTACTS, Event, spans

#: Longest time between two contacts of one pinch, s.
ONE_PINCH = 0.060
#: Longest closing, s. A longer pinch of the original recording gives its label, but no bounds.
ONE_CLOSING = 5.0


@dataclass(frozen=True, slots=True)
class Labeller:
    """Origin of labels: name of the person, date, and program."""

    name: str
    when: str
    tool: str


def write_labelled(
    recording: Recording, marks: Sequence[Mark], path: Path, by: Labeller
) -> tuple[int, int]:
    """Write a copy of a recording to ``path``, in which each accepted contact begins a pinch.

    Return the number of pinches, and the number of contacts without a decision. Raises FileError if
    ``path`` exists.
    """
    accepted = [m for m in marks if m.status is Status.ACCEPTED]
    left = sum(m.status is Status.FOUND for m in marks)
    notes = [*recording.header.notes.splitlines(), _note(marks, by), *recording.skipped]
    notes = [line for line in notes if NO_CONTACTS not in line]
    header = replace(recording.header, notes="\n".join(notes))
    pinches = list(_pinch_marks(recording, accepted))
    try:
        with creating(path) as temporary:
            _write(temporary, header, recording, pinches, accepted, by)
    except FileExistsError as error:
        raise FileError(
            f"{path} exists and recordings are never overwritten: choose another folder"
        ) from error
    except OSError as error:
        raise FileError(
            f"{path} cannot be written ({error.strerror}): make room on the disk and run the "
            "command again"
        ) from error
    return len(pinches), left


def _note(marks: Sequence[Mark], by: Labeller) -> str:
    taken = [m for m in marks if m.status is Status.ACCEPTED]
    added = sum(m.found is None for m in taken)
    moved = sum(m.found not in (None, m.sample) for m in taken)
    rejected = sum(m.status is Status.REJECTED for m in marks)
    left = sum(m.status is Status.FOUND for m in marks)
    return (
        f"labelled by {by.name} on {by.when} with {by.tool}: of {len(marks) - added} onsets that "
        f"the onset finder proposed {len(taken) - added} accepted ({moved} of them moved), "
        f"{rejected} rejected, {left} not looked at; {counted(added, 'onset')} added"
    )


def _write(
    path: Path,
    header: Header,
    recording: Recording,
    pinches: Sequence[PinchMark],
    accepted: Sequence[Mark],
    by: Labeller,
) -> None:
    with RecordingWriter(path, header) as writer:
        for block in recording.stretches:
            writer.write(block)
            for name, blocks in recording.groups.items():
                for slow in blocks:
                    if slow.epoch == block.epoch and _begins_during(recording, name, slow, block):
                        writer.write(slow, name)
        for marker in recording.markers:
            writer.marker(marker)
        for mark in accepted:
            block = recording.stretches[mark.stretch]
            how = _how(mark, recording.header.layout.rate)
            at = block.first_sample + mark.sample
            writer.marker(Marker(at, f"contact {how} by {by.name}", block.epoch))
        for pinch in pinches:
            writer.mark(pinch)


def _how(mark: Mark, rate: float) -> str:
    if mark.found is None:
        return "added"
    if mark.found == mark.sample:
        return "accepted"
    return f"moved by {1e3 * (mark.sample - mark.found) / rate:+.2f} ms"


def _begins_during(recording: Recording, name: str, slow: Block, block: Block) -> bool:
    """Return True if the block ``slow`` of the slower group ``name`` belongs to ``block``.

    It belongs to the first block of its epoch that ends after it begins, or else to the last one.
    """
    layout = recording.header.layout
    rate = next(g.layout.rate for g in layout.groups if g.name == name)
    first = slow.first_sample * layout.rate / rate
    mine = [b for b in recording.stretches if b.epoch == slow.epoch]
    owner = next((b for b in mine if first < b.end), mine[-1])
    return owner is block


def _pinch_marks(recording: Recording, accepted: Sequence[Mark]) -> Iterator[PinchMark]:
    """Yield the mark of a pinch for each accepted contact.

    If a contact of the other finger follows within ``ONE_PINCH`` s, it is the second contact of the
    same pinch.
    """
    rate = recording.header.layout.rate
    fingers = recording.header.layout.vibration_fingers
    groups: list[list[Mark]] = []
    for mark in accepted:
        alone = groups[-1][0] if groups and len(groups[-1]) == 1 else None
        if (
            alone is not None
            and alone.stretch == mark.stretch
            and alone.column != mark.column
            and mark.sample - alone.sample <= ONE_PINCH * rate
        ):
            groups[-1].append(mark)
        else:
            groups.append([mark])
    events = [Event(k, g[0].stretch, None, g[0].sample) for k, g in enumerate(groups)]
    starts, stops = spans(events, [len(s.data) for s in recording.stretches], rate)
    for number, (group, start, stop) in enumerate(zip(groups, starts, stops, strict=True)):
        block = recording.stretches[group[0].stretch]
        first = block.first_sample
        contacts = tuple(
            Contact(fingers[m.column], first + m.sample, first + m.sample) for m in group
        )
        begin, end, motor, speed, label = first + start, first + stop, None, None, Label()
        inside = (p for p in recording.pinches if is_inside(p, block, group[0].sample))
        original = next(inside, None)
        if original is not None:
            label = original.label
            neighbours = [g[0] for g in groups if g[0].stretch == group[0].stretch]
            is_alone = sum(is_inside(original, block, mark.sample) for mark in neighbours) == 1
            is_short = original.end - original.first_sample <= ONE_CLOSING * rate
            if is_alone:
                speed = original.closing_speed
            if is_short:
                motor = original.motor_start
            if is_alone and is_short:
                begin, end = original.first_sample, original.end
        end = max(end, contacts[-1].sample + 1)
        if motor is not None and not begin <= motor < contacts[0].sample:
            motor = None
        named = group[0].object
        labelled = replace(
            label,
            object=named,
            **measured(group[0]),
            hardness_rank=label.hardness_rank if label.object in ("", named) else None,
            specimen=label.specimen if label.object == named else named,
            shape=label.shape if label.object in ("", named) else "",
        )
        yield PinchMark(
            number, begin, end, block.epoch, labelled, contacts, motor, closing_speed=speed
        )


def is_inside(pinch: PinchMark, block: Block, sample: int) -> bool:
    """Return True if a marked pinch contains a sample, which counts from the start of ``block``."""
    at = block.first_sample + sample
    return pinch.epoch == block.epoch and pinch.first_sample <= at < pinch.end
