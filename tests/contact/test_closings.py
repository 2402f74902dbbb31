"""Closings of a stream with gaps and new epochs, in blocks of any sizes."""

import itertools

from hand_stream import CALIBRATION, LAYOUT, hand_stream
from hypothesis import given, settings
from hypothesis import strategies as st

from firstcontact.contact import ThresholdDetector
from firstcontact.contact.closing import ClosingBegan, ClosingEnded, Closings
from firstcontact.core import Block, Contact

DATA, CLOSINGS = hand_stream(4)
#: Numbers of samples in a block, used in turn.
SIZES = st.lists(st.integers(1, 5000), min_size=1, max_size=6)


def stages(streams: list[tuple[int, int, int]], sizes: list[int]) -> list[object]:
    """Return the closings of parts of DATA, and the contacts in them.

    A part is its first sample, the sample after its last one, and its epoch.
    """
    closings = Closings(LAYOUT, ThresholdDetector(10.0), CALIBRATION)
    size, found = itertools.cycle(sizes), []
    for place, end, epoch in streams:
        while place < end:
            stop = min(end, place + next(size))
            for stage in closings.update(Block(DATA[place:stop], place, epoch)):
                is_edge = isinstance(stage, (ClosingBegan, ClosingEnded))
                found += [stage] if is_edge else stage.contacts
            place = stop
    return found


@settings(max_examples=25)
@given(
    edges=st.lists(st.integers(0, len(DATA)), min_size=2, max_size=8, unique=True),
    epochs=st.lists(st.integers(0, 1), min_size=4, max_size=4),
    sizes=SIZES,
)
def test_blocks_do_not_matter(edges: list[int], epochs: list[int], sizes: list[int]) -> None:
    """Neither after lost samples, nor in a new epoch, nor for a stream that begins later than 0."""
    pairs = zip(*[iter(sorted(edges))] * 2, strict=False)
    streams = [(a, b, sum(epochs[: k + 1])) for k, (a, b) in enumerate(pairs)]
    assert stages(streams, sizes) == stages(streams, [5])


def test_one_block_that_begins_an_epoch_has_all_its_closings() -> None:
    found = stages([(0, 500, 0), (0, len(DATA), 1)], [10**6])
    contacts = [s.sample for s in found if isinstance(s, Contact)]
    for closing in CLOSINGS:
        assert any(abs(sample - closing.first) < 5 for sample in contacts)
    ends = [s for s in found if isinstance(s, ClosingEnded)]
    assert {(end.epoch, end.is_complete) for end in ends} == {(1, True)}
