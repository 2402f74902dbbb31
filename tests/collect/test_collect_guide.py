"""Guided recordings, their plans, and sessions that continue after a recorder was killed."""

from collections import Counter
from pathlib import Path

import numpy as np
import pytest
from memory_source import CALIBRATION, LAYOUT, RATE, Hand, MemorySource, arrivals, samples

from firstcontact.collect.guide import Guide, Item, read_plan
from firstcontact.collect.session import Screen, run_session, session_progress
from firstcontact.contact import ThresholdDetector, detect
from firstcontact.core import Block, Finger, InputError, Label, Layout, Role
from firstcontact.device import Arrival, Descriptor
from firstcontact.recording import (
    Header,
    Marker,
    PinchMark,
    RecordingWriter,
    load_dataset,
    read_recording,
)

BLOCK = Item("block 29", 5, 29.0, "b29")


def judge(guide, blocks):
    return [j for arrival in blocks for j in guide.update(arrival)] + guide.finish()


def guided(hand, items=(BLOCK,), length=50, markers=()):
    guide = Guide(LAYOUT, items, "1", CALIBRATION)
    return guide, judge(guide, arrivals(hand.raw(), length, markers))


def closings(n, seed=0):
    hand = Hand(seed)
    hand.pause()
    return hand, [hand.close() for _ in range(n)]


def test_good_pinches_count_and_are_marked_at_their_samples():
    hand, touches = closings(5)
    guide, judgements = guided(hand)
    assert [(j.k, j.wanted, j.faults) for j in judgements] == [(k + 1, 5, ()) for k in range(5)]
    assert guide.current is None
    for number, (judged, touch) in enumerate(zip(judgements, touches, strict=True)):
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


@pytest.mark.parametrize("length", [pytest.param(1, marks=pytest.mark.slow), 7, 333, 100_000])
def test_blocks_of_any_size_give_the_same_pinches(length):
    hand, _ = closings(3, seed=1)
    _, expected = guided(hand)
    _, judgements = guided(hand, length=length)
    assert [(j.mark, j.faults) for j in judgements] == [(j.mark, j.faults) for j in expected]


@pytest.mark.parametrize(
    ("settings", "fault_text"),
    [
        ({"loud": 20.0}, "piezo clipped"),
        ({"strips": (Finger.INDEX,)}, "the thumb's strip did not close"),
        ({"silent": (Finger.THUMB,)}, "the thumb's piezo and strip do not agree"),
        ({"late_strip": 0.02}, "piezo and strip do not agree"),
        ({"strips": ()}, "the index finger's strip did not close"),
    ],
)
def test_a_pinch_with_a_fault_does_not_count(settings, fault_text):
    hand = Hand()
    hand.pause()
    hand.close()
    hand.close(**settings)
    hand.close()
    guide, judgements = guided(hand)
    assert [bool(j.faults) for j in judgements] == [False, True, False]
    assert any(fault_text in fault for fault in judgements[1].faults)
    assert judgements[1].mark is None
    assert [j.k for j in judgements] == [1, 1, 2]
    assert guide.left_out == 1
    assert judgements[2].mark.number == 1  # numbers have no hole where a closing did not count


def test_a_pinch_with_lost_samples_does_not_count():
    hand, touches = closings(3, seed=3)
    gap = min(touches[1].contacts.values()) + 100
    data = hand.raw()
    blocks = arrivals(data[:gap]) + arrivals(data[gap + 5 :], first=gap + 5)
    guide = Guide(LAYOUT, (BLOCK,), "1", CALIBRATION)
    judgements = judge(guide, blocks)
    assert [j.faults[:1] for j in judgements] == [(), ("samples were lost",), ()]


def test_without_strips_contacts_come_from_the_detector():
    layout = Layout(LAYOUT.channels[:14], LAYOUT.rate)
    hand, touches = closings(3, seed=5)
    guide = Guide(layout, (BLOCK,), "1", CALIBRATION)
    judgements = judge(guide, arrivals(hand.raw()[:, :14]))
    assert [j.faults for j in judgements] == [(), (), ()]
    for judged, touch in zip(judgements, touches, strict=True):
        assert judged.mark.truth == ()
        first = min(touch.contacts.values())
        assert abs(judged.mark.end - first - samples(0.3)) < samples(0.002)


def test_pinches_of_the_previous_object_do_not_count():
    hand, touches = closings(4, seed=6)
    twin_objects = ["block 10", "block 10", "block 29", "block 29"]
    markers = [Marker(t.motor, f"twin: {o}") for t, o in zip(touches, twin_objects, strict=True)]
    items = (Item("block 10", 1), Item("block 29", 2))
    guide, judgements = guided(hand, items, markers=markers)
    assert [j.label.object for j in judgements] == ["block 10", "block 29", "block 29", "block 29"]
    assert judgements[1].faults == ("the twin still held block 10",)
    assert guide.current is None


def test_closings_during_an_object_change_do_not_count():
    hand, _ = closings(2, seed=7)
    guide = Guide(LAYOUT, (BLOCK,), "1", CALIBRATION)
    guide.paused = True
    assert judge(guide, arrivals(hand.raw())) == []


class Silent(Screen):
    """Screen that shows nothing, for a person who is always ready."""

    def __init__(self, asks: bool = False) -> None:
        self.asks, self.objects, self.judgements = asks, [], []

    def next_object(self, label, recorded, wanted):
        self.objects.append((label.object, recorded, wanted))
        return not self.asks

    def judged(self, judged):
        self.judgements.append(judged)


def record(folder, hand, items, session="1"):
    source = MemorySource(arrivals(hand.raw()))
    progress = session_progress(folder, session, source.descriptor)
    guide = Guide(LAYOUT, items, session, CALIBRATION, progress.counts)
    header = source.descriptor.header(
        session=session, calibration=CALIBRATION, hand="left hand", notes="a note"
    )
    screen = Silent()
    complete = run_session(source, guide, progress.path, header, screen)
    return progress.path, complete, screen, source


def test_an_interrupted_session_continues(tmp_path):
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
    progress = session_progress(tmp_path, "1", source.descriptor)
    assert progress.counts == Counter({items[0].label("1"): 2, items[1].label("1"): 3})
    dataset = load_dataset(tmp_path)
    assert dataset.notes == ("a note",)
    assert sorted(dataset.objects.tolist()) == ["block 10"] * 2 + ["block 29"] * 3
    assert set(dataset.sessions.tolist()) == {"1"}
    assert all(len(p.truth) == 2 for p in dataset.pinches)
    header = read_recording(path).header
    assert (header.calibration, header.hand, header.session) == (CALIBRATION, "left hand", "1")


def test_object_marker_is_sent_after_a_reconnection(tmp_path):
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
    header = source.descriptor.header(session="1", calibration=CALIBRATION)
    assert run_session(source, guide, tmp_path / "a.mcap", header, Silent())
    assert source.marks == ["object: block 10", "object: block 29"]


def test_recording_contains_all_samples_of_rejected_pinches(tmp_path):
    hand = Hand()
    hand.pause()
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


def test_a_write_error_ends_the_session(tmp_path):
    hand, _ = closings(2)
    source = MemorySource(arrivals(hand.raw()))
    source.left.insert(30, Arrival(Block(np.zeros((5, 16), np.float32), 1500), 0.0))
    guide = Guide(LAYOUT, (BLOCK,), "1", CALIBRATION)
    header = source.descriptor.header(session="1", calibration=CALIBRATION)
    with pytest.raises(InputError, match=r"a\.mcap"):
        run_session(source, guide, tmp_path / "a.mcap", header, Silent())
    assert read_recording(tmp_path / "a.mcap").samples == 1500


def test_a_plan_is_read(tmp_path):
    path = tmp_path / "plan.csv"
    path.write_text(
        "object,shore,specimen,pinches,role\nblock 29,29,b29,20,train\nApfel 🍎,,,5,test\n",
        encoding="utf-8",
    )
    assert read_plan(path) == (
        Item("block 29", 20, 29.0, "b29", Role.TRAIN),
        Item("Apfel 🍎", 5, None, "", Role.TEST),
    )
    assert read_plan(path)[1].label("2") == Label(
        "Apfel 🍎", None, None, "Apfel 🍎", "2", Role.TEST
    )


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("object,pinches,colour\na,1,red\n", "'colour'"),
        ("object,shore\na,1\n", "'pinches'"),
        ("object,pinches\n", "plan.csv"),
        ("object,pinches\na,many\n", "line 2: pinches"),
        ("object,pinches\na,1_0\n", "line 2: pinches"),
        ("object,pinches,shore\na,1,soft\n", "line 2: shore"),
        ("object,pinches,role\na,1,both\n", "line 2: role"),
        ("object,pinches\na,0\n", "line 2: the number of pinches of a is 0"),
        ("object,pinches\n,3\n", "line 2"),
        ("object,pinches,shore\na,1,120\n", "line 2: shore of a is 120"),
        ("object,pinches\na,1\na,2\n", "line 3: a"),
        ("object,pinches\na,1,5\nb\n", "line 3: pinches"),
    ],
)
def test_invalid_plans_are_refused(tmp_path, text, problem):
    path = tmp_path / "plan.csv"
    path.write_text(text)
    with pytest.raises(InputError, match=problem):
        read_plan(path)


DESCRIPTOR = Descriptor(LAYOUT, source="twin")
LABEL = Label("block 20", 20.0, None, "block 20", "1")


def part(path: Path, label: Label = LABEL) -> Path:
    """Write a complete recording of one pinch."""
    with RecordingWriter(path, Header(LAYOUT, "twin", session="1")) as writer:
        writer.write(Block(np.zeros((2000, 16), np.int16)))
        writer.mark(PinchMark(0, 100, 900, 0, label))
    return path


@pytest.mark.parametrize("length", [0, 41, 4096, 8192])
def test_session_continues_after_an_unreadable_part(tmp_path: Path, length: int) -> None:
    damaged = tmp_path / "session-1.mcap"
    content = part(damaged).read_bytes()[:length]
    damaged.write_bytes(content)
    progress = session_progress(tmp_path, "1", DESCRIPTOR)
    assert progress.path == tmp_path / "session-1.part2.mcap"
    assert (progress.files, progress.counts) == ((), {})
    (message,) = progress.unreadable
    assert str(damaged) in message
    part(progress.path)
    resumed = session_progress(tmp_path, "1", DESCRIPTOR)
    assert resumed.path == tmp_path / "session-1.part3.mcap"
    assert (resumed.files, resumed.counts[LABEL]) == ((progress.path,), 1)
    assert damaged.read_bytes() == content
    dataset = load_dataset(tmp_path)
    assert len(dataset) == 1
    assert sum(str(damaged) in loss for loss in dataset.losses) == 1
    with pytest.raises(InputError, match=r"session-1\.mcap"):
        load_dataset(damaged)


def test_file_of_another_session_is_refused(tmp_path: Path) -> None:
    part(tmp_path / "session-a-b.mcap")
    with pytest.raises(InputError, match=r"session-a-b\.mcap .*'1'") as error:
        session_progress(tmp_path, "a b", DESCRIPTOR)
    assert error.value.parameter == "session"
