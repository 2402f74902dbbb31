"""The guided protocol on a hand that closes as it is told to."""

from collections import Counter

import numpy as np
import pytest
from memory_source import CALIBRATION, LAYOUT, RATE, Hand, MemorySource, arrivals, samples

from firstcontact.collect import Guide, Item, header_of, run_session, so_far
from firstcontact.contact import ThresholdDetector, detect
from firstcontact.core import Block, Finger, InputError, Layout
from firstcontact.device import Arrival
from firstcontact.recording import Marker, load_dataset, read_recording

BLOCK = Item("block 29", 5, 29.0, "b29")


def judge(guide, made):
    return [j for arrival in made for j in guide.update(arrival)] + guide.finish()


def guided(hand, items=(BLOCK,), length=50, markers=()):
    guide = Guide(LAYOUT, items, "1", CALIBRATION)
    return guide, judge(guide, arrivals(hand.raw(), length, markers))


def closings(n, seed=0):
    hand = Hand(seed)
    hand.rest()
    return hand, [hand.close() for _ in range(n)]


def test_good_pinches_are_counted_and_marked_where_they_were():
    hand, touches = closings(5)
    guide, found = guided(hand)
    assert [(j.k, j.wanted, j.faults) for j in found] == [(k + 1, 5, ()) for k in range(5)]
    assert guide.current is None
    for number, (judged, touch) in enumerate(zip(found, touches, strict=True)):
        mark = judged.mark
        assert mark.number == number
        assert mark.label == BLOCK.label("1")
        assert {c.finger: c.sample for c in mark.truth} == touch.contacts
        first = min(touch.contacts.values())
        assert touch.motor < mark.first_sample < first - samples(0.08)
        assert mark.end == first + samples(0.3)
        assert judged.offset == pytest.approx(0.015, abs=2 / RATE)
        assert abs(judged.disagreement) < 1e-3
        assert judged.noise == pytest.approx(1.0, abs=0.1)


@pytest.mark.parametrize("length", [1, 7, 333, 100_000])
def test_blocks_of_any_size_give_the_same_pinches(length):
    hand, _ = closings(3, seed=1)
    _, wanted = guided(hand)
    _, found = guided(hand, length=length)
    assert [(j.mark, j.faults) for j in found] == [(j.mark, j.faults) for j in wanted]


def test_the_mark_begins_where_the_contacts_were_counted_from():
    # Cut out at its mark, a pinch gives the detector what it had in the stream.
    hand, touches = closings(3, seed=2)
    _, found = guided(hand)
    data = hand.raw()
    for judged, touch in zip(found, touches, strict=True):
        detector = ThresholdDetector(10.0)
        detector.start(LAYOUT)
        mark = judged.mark
        block = Block(data[mark.first_sample : mark.end], mark.first_sample)
        first = detector.update(block)[0]
        assert abs(first.sample - min(touch.contacts.values())) < samples(0.002)


@pytest.mark.parametrize(
    ("how", "said"),
    [
        ({"loud": 20.0}, "piezo clipped"),
        ({"strips": (Finger.INDEX,)}, "the thumb's strip did not close"),
        ({"silent": (Finger.THUMB,)}, "the thumb's piezo and strip do not agree"),
        ({"late_strip": 0.02}, "piezo and strip do not agree"),
        ({"strips": ()}, "the index's strip did not close"),
    ],
)
def test_a_pinch_with_a_fault_is_told_and_does_not_count(how, said):
    hand = Hand()
    hand.rest()
    hand.close()
    hand.close(**how)
    hand.close()
    guide, found = guided(hand)
    assert [bool(j.faults) for j in found] == [False, True, False]
    assert any(said in fault for fault in found[1].faults)
    assert found[1].mark is None
    assert [j.k for j in found] == [1, 1, 2]
    assert guide.left_out == 1
    assert found[2].mark.number == 1  # numbers have no hole where a closing did not count


def test_a_pinch_with_lost_samples_does_not_count():
    hand, touches = closings(3, seed=3)
    gap = min(touches[1].contacts.values()) + 100
    data = hand.raw()
    made = arrivals(data[:gap]) + arrivals(data[gap + 5 :], first=gap + 5)
    guide = Guide(LAYOUT, (BLOCK,), "1", CALIBRATION)
    found = judge(guide, made)
    assert [j.faults for j in found] == [(), ("samples were lost", *found[1].faults[1:]), ()]


def test_a_new_epoch_ends_a_pinch():
    hand, touches = closings(2, seed=4)
    cut = min(touches[0].contacts.values()) + 100
    data = hand.raw()
    made = arrivals(data[:cut]) + arrivals(data[cut:], epoch=1)
    found = judge(Guide(LAYOUT, (BLOCK,), "1", CALIBRATION), made)
    assert [bool(j.faults) for j in found] == [True, False]
    assert found[1].mark.epoch == 1


def test_closings_that_touch_nothing_are_no_pinches():
    hand = Hand()
    hand.rest()
    hand.phase(0.5, 3.0)
    hand.rest()
    hand.close()
    _, found = guided(hand)
    assert [j.faults for j in found] == [()]


def test_without_strips_contacts_are_those_detected_and_the_truth_stays_open():
    layout = Layout(LAYOUT.channels[:14], LAYOUT.rate)
    hand, touches = closings(3, seed=5)
    guide = Guide(layout, (BLOCK,), "1", CALIBRATION)
    found = judge(guide, arrivals(hand.raw()[:, :14]))
    assert [j.faults for j in found] == [(), (), ()]
    for judged, touch in zip(found, touches, strict=True):
        assert judged.mark.truth == ()
        first = min(touch.contacts.values())
        assert abs(judged.mark.end - first - samples(0.3)) < samples(0.002)


def test_objects_follow_each_other_and_what_the_twin_still_holds_does_not_count():
    hand, touches = closings(4, seed=6)
    held = ["block 10", "block 10", "block 29", "block 29"]
    markers = [Marker(t.motor, f"twin: {o}") for t, o in zip(touches, held, strict=True)]
    items = (Item("block 10", 1), Item("block 29", 2))
    guide, found = guided(hand, items, markers=markers)
    assert [j.label.object for j in found] == ["block 10", "block 29", "block 29", "block 29"]
    assert found[1].faults == ("the twin still held block 10",)
    assert guide.current is None


def test_what_closes_while_objects_are_changed_does_not_count():
    hand, _ = closings(2, seed=7)
    guide = Guide(LAYOUT, (BLOCK,), "1", CALIBRATION)
    guide.paused = True
    assert judge(guide, arrivals(hand.raw())) == []


class Silent:
    """A person who is there at once and reads nothing."""

    def __init__(self, asks: bool = False) -> None:
        self.asks, self.objects, self.told = asks, [], []

    def next_object(self, label, done, wanted):
        self.objects.append((label.object, done, wanted))
        return not self.asks

    def in_place(self):
        return True

    def judged(self, judged):
        self.told.append(judged)

    def going_on(self):
        pass


def record(folder, hand, items, session="1"):
    source = MemorySource(arrivals(hand.raw()))
    before = so_far(folder, session, source.descriptor)
    guide = Guide(LAYOUT, items, session, CALIBRATION, before.done)
    header = header_of(source.descriptor, session, CALIBRATION, "left hand", "a note")
    screen = Silent()
    complete = run_session(source, guide, before.path, header, screen)
    return before.path, complete, screen, source


def test_a_session_is_gone_on_with_after_an_interruption(tmp_path):
    items = (Item("block 10", 2, 10.0), Item("block 29", 3, 29.0))
    path, complete, screen, source = record(tmp_path, closings(3)[0], items)
    assert (path.name, complete) == ("session-1.mcap", False)
    assert screen.objects == [("block 10", 0, 2), ("block 29", 0, 3)]
    assert source.marks == source.orders == ["object: block 10", "object: block 29"]
    path, complete, screen, source = record(tmp_path, closings(9, seed=8)[0], items)
    assert (path.name, complete) == ("session-1.part2.mcap", True)
    assert screen.objects == [("block 29", 1, 3)]
    # It stopped as soon as all was there.
    assert source.health.samples < len(closings(9, seed=8)[0].raw())
    done = so_far(tmp_path, "1", source.descriptor)
    assert done.done == Counter({items[0].label("1"): 2, items[1].label("1"): 3})
    dataset = load_dataset(tmp_path)
    assert dataset.notes == ("a note",)
    assert sorted(dataset.objects.tolist()) == ["block 10"] * 2 + ["block 29"] * 3
    assert set(dataset.sessions.tolist()) == {"1"}
    assert all(len(p.truth) == 2 for p in dataset.pinches)
    header = read_recording(path).header
    assert (header.calibration, header.hand, header.session) == (CALIBRATION, "left hand", "1")


def test_a_device_that_is_unplugged_when_the_object_changes_is_told_later(tmp_path):
    class Unplugged(MemorySource):
        away = 3

        def mark(self, text):
            if self.away:
                self.away -= 1
                raise InputError("the device is not there")
            super().mark(text)

    source = Unplugged(arrivals(closings(2)[0].raw()))
    items = (Item("block 10", 1, 10.0), Item("block 29", 1, 29.0))
    guide = Guide(LAYOUT, items, "1", CALIBRATION)
    header = header_of(source.descriptor, "1", CALIBRATION)
    assert run_session(source, guide, tmp_path / "a.mcap", header, Silent())
    assert source.marks == ["object: block 10", "object: block 29"]


def test_everything_that_came_is_in_the_file_also_what_did_not_count(tmp_path):
    hand = Hand()
    hand.rest()
    hand.close(loud=20.0)
    hand.close()
    path, complete, _, _ = record(tmp_path, hand, (Item("block 10", 3),))
    recording = read_recording(path)
    (stretch,) = recording.stretches
    assert not complete
    assert np.array_equal(stretch.data, hand.raw())
    assert len(recording.pinches) == 1
    (pinch,) = load_dataset(path).pinches
    assert detect(ThresholdDetector(10.0), pinch)


def test_what_cannot_be_written_ends_the_session_with_its_sentence(tmp_path):
    hand, _ = closings(2)
    source = MemorySource(arrivals(hand.raw()))
    source.left.insert(30, Arrival(Block(np.zeros((5, 16), np.float32), 1500), 0.0))
    guide = Guide(LAYOUT, (BLOCK,), "1", CALIBRATION)
    header = header_of(source.descriptor, "1", CALIBRATION)
    with pytest.raises(InputError, match="dtype"):
        run_session(source, guide, tmp_path / "a.mcap", header, Silent())
    assert read_recording(tmp_path / "a.mcap").samples == 1500


def test_recordings_that_cannot_be_one_dataset_are_refused(tmp_path):
    path, *_ = record(tmp_path, closings(1)[0], (BLOCK,))
    descriptor = MemorySource().descriptor
    other = type(descriptor)(Layout(LAYOUT.channels[:2], RATE), source="synthetic")
    with pytest.raises(InputError, match="another sensor or layout"):
        so_far(tmp_path, "1", other)
    path.rename(tmp_path / "session-2.mcap")
    with pytest.raises(InputError, match="belongs to session '1'"):
        so_far(tmp_path, "2", descriptor)
