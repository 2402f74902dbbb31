"""The twin's hand, which executes commands, and its default model."""

import math
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest

import firstcontact as fc
from firstcontact.core import Command, fingertip_layout
from firstcontact.core.layout import FINGERTIP_RATE
from firstcontact.device import Arrival, Descriptor, Source
from firstcontact.device.twin_hand import TwinHand
from firstcontact.device.twin_process import TwinOptions
from firstcontact.device.twin_source import TwinSource
from firstcontact.device.twin_words import parse_held_object
from firstcontact.grasp import Hand, HandError
from firstcontact.recording import Marker, load_dataset, read_recording
from firstcontact.streaming.twin import SHIPPED_HAND, twin_model

#: A source that is silent for so long is dead, s.
DEAD = 60.0


@pytest.fixture(scope="module")
def source() -> Iterator[TwinSource]:
    with TwinSource(TwinOptions(seed=4, speed=2)) as source:
        yield source


@pytest.fixture
def hand(source: TwinSource) -> Hand:
    return TwinHand(source)


def heard(source: Source, enough: Callable[[list[Marker]], bool]) -> list[Marker]:
    """Return the next markers, until there are enough."""
    markers: list[Marker] = []
    while not enough(markers):
        arrivals: list[Arrival] = source.read(DEAD)
        assert arrivals, "the twin has gone silent"
        markers += [m for a in arrivals for m in a.markers]
    return markers


def next_start(source: Source) -> int:
    """Return the sample at which the next closing begins.

    Its end may be known as well, because a busy machine reads late.
    """
    markers = heard(source, lambda ms: any(parse_held_object(m.text) for m in ms))
    return max(m.sample for m in markers if parse_held_object(m.text))


def test_the_twin_hears_each_order_as_it_was_given(source: TwinSource, hand: Hand) -> None:
    with hand:
        hand.send(Command(0.0123, 4.5))

    def orders(markers: list[Marker]) -> list[str]:
        """Return the orders in the markers, from the first order of this test on."""
        words = [m.text.partition("hand: ")[2] for m in markers if "hand: " in m.text]
        return words[words.index("0.0123 4.500") :] if "0.0123 4.500" in words else []

    markers = heard(source, lambda ms: len(orders(ms)) >= 2)
    assert orders(markers) == ["0.0123 4.500", "release"]


def test_the_twin_closes_when_it_is_asked() -> None:
    with (
        TwinSource(TwinOptions(objects=["block 29"], seed=4, speed=2)) as source,
        TwinHand(source) as hand,
    ):
        for _ in range(2):
            hand.start()
            markers = heard(source, lambda ms: any("peak" in m.text for m in ms))
            (asked,) = (m.sample for m in markers if m.text.endswith("hand: close"))
            starts = [m.sample for m in markers if parse_held_object(m.text) and m.sample >= asked]
            assert starts[0] - asked < 0.6 * FINGERTIP_RATE


def test_a_commanded_hand_squeezes_less() -> None:
    with TwinSource(TwinOptions(objects=["block 10"], seed=4)) as source, TwinHand(source) as hand:
        predictions: float | None = None
        while predictions is None:
            start = next_start(source)
            hand.send(Command(0.03, 1.0))
            markers = heard(source, lambda ms: any("peak" in m.text for m in ms))
            arrival = next(m.sample for m in markers if m.text.endswith("hand: 0.0300 1.000"))
            # One that came late is for a closing after this one to show.
            if arrival - start < 900:
                predictions = next(peak(m) for m in markers if "peak" in m.text)
        alone = heard(source, lambda ms: sum("peak" in m.text for m in ms) >= 2)
    assert predictions < 0.6 * min(peak(m) for m in alone if "peak" in m.text)


def peak(marker: Marker) -> float:
    return float(marker.text.split()[2])


def test_its_positions_tell_the_closing_speed() -> None:
    with (
        TwinSource(TwinOptions(objects=["block 29"], seed=4, speed=2)) as source,
        TwinHand(source) as hand,
    ):
        source.read(DEAD)
        assert hand.closing_speed(0.0, math.nan) is None  # nothing moved before
        start = next_start(source)
        contact = start + round(0.2 * FINGERTIP_RATE)
        end = start
        while end < contact:
            end = source.read(DEAD)[-1].block.end
        speed = hand.closing_speed(contact / FINGERTIP_RATE, math.nan)
    assert 0.08 < speed.speed < 0.2
    assert 0.001 < speed.error < 0.01
    assert hand.closing_speed(contact / FINGERTIP_RATE, math.nan) is None


def test_a_recording_keeps_its_positions(tmp_path: Path) -> None:
    """The positions so far are in the file at any time, so also after a kill."""
    so_far, copy = [], tmp_path / "copy.mcap"
    with fc.open("twin", speed=8.0, seed=4) as source:
        for event in fc.live(source, hand="twin", pinches=2, record=tmp_path / "made"):
            if isinstance(event, fc.PinchDone):
                (path,) = (tmp_path / "made").iterdir()
                copy.write_bytes(path.read_bytes())
                so_far.append(len(read_recording(copy).hand_positions[0]))
    recording = read_recording(path)
    assert recording.skipped == ()
    times, travel = recording.hand_positions
    assert 0 < so_far[0] < so_far[1] <= len(times)
    assert np.diff(times) == pytest.approx(1 / TwinHand.position_rate)
    for mark, pinch in zip(recording.pinches, load_dataset(path), strict=True):
        first = mark.truth[0].sample / FINGERTIP_RATE
        measured = fc.closing_speed(times, travel, first)
        assert measured.speed == pytest.approx(
            mark.closing_speed.speed, abs=mark.closing_speed.error
        )
        at, values = pinch.group("hand")
        begin = pinch.first_sample / FINGERTIP_RATE
        assert np.allclose(values[:, 0], np.interp(at + begin, times, travel))


class Real(TwinSource):
    """Source that does not identify itself as a twin."""

    @property
    def descriptor(self) -> Descriptor:
        return Descriptor(fingertip_layout(), source="real")


def test_only_a_twin_has_it() -> None:
    with pytest.raises(HandError, match="--device twin"), TwinHand(Real(TwinOptions())):
        raise AssertionError


def test_the_default_hand_has_a_model_without_training(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    model = fc.load_model(twin_model(*SHIPPED_HAND))
    assert list(tmp_path.iterdir()) == []
    # The network knows more than the flat blocks, from which the SVM learned.
    unseen = fc.simulate(tmp_path / "objects", pinches_per_block=0, pinches_per_object=2)
    evaluation = fc.evaluate(model, unseen)[0]
    (group,) = evaluation.groups
    assert evaluation.predictor == "combined"
    assert group.title == "not seen in training"
    assert max(group.rmse.values()) < group.constant


def test_a_missing_package_is_named_before_the_simulation(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setattr("firstcontact.core.installation.find_spec", lambda module: None)
    with pytest.raises(fc.InputError, match="train"):
        twin_model("paper-rig", 3)
    assert list(tmp_path.iterdir()) == []
