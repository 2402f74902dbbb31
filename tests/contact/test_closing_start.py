"""Where a closing starts: as live, as labels say, and the first sample where nothing tells."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hand_stream import CALIBRATION, FLOOR, LAYOUT, Closing, hand_stream
from hypothesis import given
from hypothesis import strategies as st
from rested import rested

from firstcontact.contact import (
    closing_start,
    closing_starts,
    count_starts,
    cut_closings,
    describe_starts,
    detect,
)
from firstcontact.contact._closing_start import ClosingStart, How, settling
from firstcontact.contact._gate import ClosingGate, Turn
from firstcontact.core import (
    Block,
    Calibration,
    Channel,
    ChannelKind,
    Contact,
    Dataset,
    Finger,
    InputError,
    Label,
    Layout,
    Pinch,
    VibrationCalibration,
)
from firstcontact.recording import from_arrays
from firstcontact.signal import resample_dataset, samples_in
from firstcontact.testing import closings as toy_closings

DATA, CLOSINGS = hand_stream(3)
STEP = samples_in(0.003, LAYOUT.rate)
OPENED = [
    event.sample
    for event in ClosingGate(LAYOUT, CALIBRATION).update(Block(DATA))
    if event.turn is Turn.OPENS
]


def waits(dataset: Dataset) -> list[int]:
    """From the first sample of each pinch to the start of its closing, samples."""
    starts = closing_starts(dataset)
    return [s.sample - p.first_sample for s, p in zip(starts, dataset.pinches, strict=True)]


def rig(
    floor: tuple[float, ...] = (1.0, 1.0),
    motor: tuple[float, ...] = (6.0, 6.0),
    contact: float = 200.0,
    rest: float = 0.12,
    lead: float = 0.15,
    rate: float = 5000.0,
    n: int = 12,
    seed: int = 0,
    fades: float = 0.01,
) -> Dataset:
    """Another rig than the twin's: white rest and motor (RMS, mV), a contact that rings, mV."""
    rng = np.random.default_rng(seed)
    layout = Layout(
        tuple(Channel(f"p{f}", ChannelKind.VIBRATION, Finger(f), "V") for f in range(len(floor))),
        rate,
    )
    pinches = []
    for i in range(n):
        runs = round(rest * rng.uniform(0.8, 1.2) * rate) if rest else 0
        touches = runs + round(lead * rate)
        t = np.arange(round(0.3 * rate)) / rate
        x = rng.standard_normal((touches + len(t), len(floor)))
        x[:runs] *= floor
        x[runs:] *= motor
        ring = contact * np.exp(-t / fades) * np.sin(2 * np.pi * 150 * t)
        x[touches:] += ring[:, None]
        first = 10_000 * i
        truth = (Contact(Finger.INDEX, first + touches, first + touches),)
        pinches.append(
            Pinch((1e-3 * x).astype(np.float32), layout, Label(session="s"), first, truth)
        )
    return Dataset(tuple(pinches), "synthetic")


def test_a_motor_that_starts_later_is_waited_for() -> None:
    dataset = rig()
    assert count_starts(closing_starts(dataset)) == {"rest": 12}
    for pinch, start in zip(dataset.pinches, closing_starts(dataset), strict=True):
        assert pinch.first is not None
        motor = pinch.first.sample - round(0.15 * 5000)
        assert motor + settling(pinch.layout) - 2 * STEP <= start.sample <= motor + 0.06 * 5000


def test_a_motor_that_runs_from_the_first_sample_is_not() -> None:
    for dataset in (rig(rest=0.0), toy_closings(20)):
        assert waits(dataset) == [0] * len(dataset)
        assert set(count_starts(closing_starts(dataset))) == {"first_sample"}


@pytest.mark.parametrize("fades", [0.003, 0.01, 0.03, 0.1, 0.5])
@pytest.mark.parametrize("rest", [0.0, 0.12])
def test_a_contact_without_a_motor_is_no_start(fades: float, rest: float) -> None:
    """Impacts on a microphone: quiet, a loud onset, a ring however long."""
    dataset = rig(motor=(1.0,), floor=(1.0,), fades=fades, rest=rest)
    assert waits(dataset) == [0] * len(dataset)


def test_the_length_of_the_rest_does_not_matter() -> None:
    for rest in (0.05, 0.1, 0.4):
        assert count_starts(closing_starts(rig(rest=rest))) == {"rest": 12}


@pytest.mark.parametrize("rate", [2200.0, 4936.0, 16_000.0])
def test_nor_does_the_rate(rate: float) -> None:
    assert count_starts(closing_starts(rig(rate=rate))) == {"rest": 12}


def test_a_finger_that_does_not_hear_the_motor_decides_nothing() -> None:
    assert count_starts(closing_starts(rig(motor=(6.0, 1.0)))) == {"rest": 12}
    assert count_starts(closing_starts(rig(floor=(1.0, 0.0), motor=(6.0, 0.0)))) == {"rest": 12}


def test_rest_may_be_exact_silence() -> None:
    assert count_starts(closing_starts(rig(floor=(0.0, 0.0)))) == {"rest": 12}


def test_a_single_pinch_is_enough_where_it_is_clear() -> None:
    assert count_starts(closing_starts(rig(n=1))) == {"rest": 1}
    assert count_starts(closing_starts(rig(n=1, rest=0.0))) == {"first_sample": 1}


def test_pinches_of_both_kinds_in_one_session() -> None:
    with_rest, without = rig(n=12), rig(n=6, rest=0.0, seed=1)
    both = replace(with_rest, pinches=with_rest.pinches + without.pinches)
    starts = closing_starts(both)
    assert [s.how for s in starts] == [How.REST] * 12 + [How.FIRST_SAMPLE] * 6


def test_sessions_of_two_rigs_have_floors_of_their_own() -> None:
    loud = rig(floor=(6.0, 6.0), motor=(30.0, 30.0), contact=2000.0, seed=1)
    moved = tuple(replace(p, label=Label(session="other")) for p in loud.pinches)
    both = replace(loud, pinches=rig().pinches + moved)
    assert count_starts(closing_starts(both)) == {"rest": 24}


def test_the_label_wins() -> None:
    dataset = rig()
    pinch = dataset.pinches[0]
    labelled = replace(pinch, motor_start=pinch.first_sample + 40)
    assert closing_start(labelled).sample == pinch.first_sample + 40 + settling(pinch.layout)
    assert closing_start(labelled).how is How.LABEL
    # Ran already when the recording began: nothing is waited for.
    for early in (0, pinch.first_sample):
        assert closing_start(replace(pinch, motor_start=early)).sample == pinch.first_sample
    far = replace(pinch, motor_start=pinch.first_sample + len(pinch.data) - 5)
    assert closing_start(far).sample == pinch.first_sample + len(pinch.data)
    assert len(cut_closings(Dataset((far,))).pinches[0].data) == 0


def test_resampling_moves_the_start_along() -> None:
    dataset = resample_dataset(rig(rate=10_000.0), 4936.0)
    assert count_starts(closing_starts(dataset)) == {"rest": 12}


def opening(closing: Closing) -> int:
    """Where the gate of the whole stream opens for a closing."""
    return next(s for s in OPENED if closing.motor < s < closing.first)


@given(st.sampled_from(CLOSINGS), st.integers(32, 90))
def test_with_a_calibration_it_is_where_live_opens(closing: Closing, steps: int) -> None:
    opened = opening(closing)
    first = opened - steps * STEP  # in the rest before the motor, on the gate's own grid
    pinch = Pinch(DATA[first : closing.rest], LAYOUT, first_sample=first, calibration=CALIBRATION)
    assert closing_start(pinch) == ClosingStart(opened, How.CALIBRATION)


def test_what_live_has_cut_out_stays_whole() -> None:
    """A recording's pinches begin where the gate opened: offline must start there, too."""
    for closing in CLOSINGS:
        opened = opening(closing)
        data = DATA[opened : closing.rest]
        for calibration in (CALIBRATION, None):
            pinch = Pinch(data, LAYOUT, first_sample=opened, calibration=calibration)
            assert closing_start(pinch).sample == opened
            assert waits(Dataset((pinch,))) == [0]


def test_a_calibration_of_one_finger_says_nothing() -> None:
    pinch = Pinch(DATA[:3000], LAYOUT)
    one = Calibration((VibrationCalibration(Finger.INDEX, FLOOR),))
    assert closing_start(replace(pinch, calibration=one)).how is How.FIRST_SAMPLE


def test_cut_once_is_cut_for_good() -> None:
    once = cut_closings(rig())
    assert waits(once) == [0] * 12
    for a, b in zip(cut_closings(once).pinches, once.pinches, strict=True):
        assert a.first_sample == b.first_sample
        assert np.array_equal(a.data, b.data)


def test_contacts_keep_their_sample_numbers(fitted) -> None:
    plain = toy_closings(12, seed=9)
    dataset = rested(plain, electronics=0.0005)
    assert set(count_starts(closing_starts(dataset))) == {"rest"}
    right = 0
    for pinch in cut_closings(dataset).pinches:
        contacts = detect(fitted["svm"], pinch)
        right += bool(contacts) and abs(contacts[0].sample - pinch.first.sample) <= 15
    assert right >= 10


@pytest.mark.parametrize("samples", [0, 1, 100, 700])
def test_short_pinches_start_with_their_first_sample(samples: int) -> None:
    pinches = tuple(replace(p, data=p.data[:samples]) for p in rig().pinches)
    assert waits(Dataset(pinches)) == [0] * 12


def test_samples_that_are_not_finite_tell_nothing() -> None:
    dataset = rig(n=1)
    dataset.pinches[0].data[900] = np.nan
    assert waits(dataset) == [0]


def test_it_is_said_how() -> None:
    dataset = rig()
    words = "where the motor is heard above the rest before it"
    assert describe_starts(count_starts(closing_starts(dataset))) == f"steady states begin {words}"
    labelled = replace(dataset.pinches[0], motor_start=0)
    ways = count_starts(closing_starts(replace(dataset, pinches=(*dataset.pinches, labelled))))
    assert describe_starts(ways).endswith(f"motor has settled (1), {words} (12)")


@pytest.mark.parametrize("unit", [None, "V", "counts"])
def test_forces_in_any_unit_hide_no_start_of_a_motor(unit: str | None) -> None:
    """Imported: force in volts or in counts of a converter, as their unit says or not at all."""
    dataset = rested(toy_closings(8), rest=(0.2, 0.2), electronics=0.0005)
    piezo = np.array([p.vibration() for p in dataset.pinches])
    counts = np.random.default_rng(0).integers(60, 70, (*piezo.shape[:2], 2, 6))
    counts[:, -100:] += 300  # the grip
    arrays = {"piezo": piezo, "sample_rate_hz": np.array(dataset.layout.rate)}
    arrays |= {"piezo_unit": np.array("V")}
    arrays["force"] = counts * (3.3 / 1024) if unit == "V" else counts
    if unit is None:
        with pytest.raises(InputError, match=r"force .* force_unit counts"):
            from_arrays(Path("x.npz"), arrays)
        return
    imported = from_arrays(Path("x.npz"), {**arrays, "force_unit": np.array(unit)})
    assert count_starts(closing_starts(imported)) == {How.REST: 8}
    assert imported.pinches[0].force(Finger.INDEX)[0] == pytest.approx(0.2, abs=0.03)


def test_a_force_without_a_unit_hides_no_start_of_a_motor() -> None:
    """As recordings hold it that were imported before forces had a unit."""
    dataset = rested(toy_closings(8), rest=(0.2, 0.2), electronics=0.0005)
    count = Channel("force_index_0", ChannelKind.FORCE, Finger.INDEX, "", taxel=0)
    layout = Layout((*dataset.layout.channels, count), dataset.layout.rate)
    noise = np.random.default_rng(0).integers(60, 70, (8, 10_000, 1))
    pinches = tuple(
        replace(p, layout=layout, data=np.concatenate([p.data, noise[i, : len(p.data)]], axis=1))
        for i, p in enumerate(dataset.pinches)
    )
    assert count_starts(closing_starts(Dataset(pinches, "synthetic"))) == {How.REST: 8}
