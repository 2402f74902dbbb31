"""Start of a closing: from the gate or from labels, otherwise the first sample."""

from dataclasses import replace

import numpy as np
import pytest
from hand_stream import CALIBRATION, LAYOUT, OPENS, Closing, hand_stream, make_gate, turns
from hypothesis import given
from hypothesis import strategies as st

from firstcontact.contact.closing_start import (
    DetectionStart,
    StartMethod,
    closing_start,
    closing_starts,
    count_starts,
    cut_closings,
    settling,
)
from firstcontact.core import (
    Block,
    Channel,
    ChannelKind,
    Contact,
    Dataset,
    Finger,
    Label,
    Layout,
    Pinch,
)
from firstcontact.signal import samples_in
from firstcontact.testing import closings as toy_closings

DATA, CLOSINGS = hand_stream(3)
STEP = samples_in(0.003, LAYOUT.rate)
OPENED = [sample for turn, sample in turns(make_gate(), Block(DATA)) if turn == OPENS]


def waits(dataset: Dataset) -> list[int]:
    """Return the number of samples from the start of each pinch to the start of its closing."""
    starts = closing_starts(dataset)
    return [s.sample - p.first_sample for s, p in zip(starts, dataset.pinches, strict=True)]


def rig(
    floor: tuple[float, ...] = (1.0, 1.0),
    motor: tuple[float, ...] = (6.0, 6.0),
    contact: float = 200.0,
    rest_s: float = 0.12,
    lead: float = 0.15,
    rate: float = 5000.0,
    n: int = 12,
    seed: int = 0,
    fades: float = 0.01,
) -> Dataset:
    """Return pinches of a rig that differs from the twin.

    Rest and motor are white noise with an RMS in mV. The contact rings, with an amplitude in mV.
    """
    rng = np.random.default_rng(seed)
    layout = Layout(
        tuple(Channel(f"p{f}", ChannelKind.VIBRATION, Finger(f), "V") for f in range(len(floor))),
        rate,
    )
    pinches = []
    for i in range(n):
        runs = round(rest_s * rng.uniform(0.8, 1.2) * rate) if rest_s else 0
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


def test_closing_starts_after_a_late_motor() -> None:
    dataset = rig()
    assert count_starts(closing_starts(dataset)) == {"rest": 12}
    for pinch, start in zip(dataset.pinches, closing_starts(dataset), strict=True):
        motor = pinch.first.sample - round(0.15 * 5000)
        assert motor + settling(pinch.layout) - 2 * STEP <= start.sample <= motor + 0.06 * 5000


def test_closing_starts_at_once_with_a_running_motor() -> None:
    for dataset in (rig(rest_s=0.0), toy_closings(20)):
        assert waits(dataset) == [0] * len(dataset)
        assert set(count_starts(closing_starts(dataset))) == {"first_sample"}


@pytest.mark.parametrize("fades", [0.003, 0.01, 0.03, 0.1, 0.5])
@pytest.mark.parametrize("rest_s", [0.0, 0.12])
def test_contact_without_a_motor_is_no_start(fades: float, rest_s: float) -> None:
    """Impacts recorded by a microphone are quiet, then begin loudly and ring."""
    dataset = rig(motor=(1.0,), floor=(1.0,), fades=fades, rest_s=rest_s)
    assert waits(dataset) == [0] * len(dataset)


@pytest.mark.parametrize("rate", [2200.0, 4936.0, 16_000.0])
def test_start_is_found_at_any_rate(rate: float) -> None:
    assert count_starts(closing_starts(rig(rate=rate))) == {"rest": 12}


def test_finger_without_motor_noise_is_ignored() -> None:
    assert count_starts(closing_starts(rig(motor=(6.0, 1.0)))) == {"rest": 12}
    assert count_starts(closing_starts(rig(floor=(1.0, 0.0), motor=(6.0, 0.0)))) == {"rest": 12}


def test_pinches_of_both_kinds_in_one_session() -> None:
    with_rest, without_rest = rig(n=12), rig(n=6, rest_s=0.0, seed=1)
    session = replace(with_rest, pinches=with_rest.pinches + without_rest.pinches)
    starts = closing_starts(session)
    assert [s.how for s in starts] == [StartMethod.REST] * 12 + [StartMethod.FIRST_SAMPLE] * 6


def test_each_session_has_its_noise_floor() -> None:
    loud = rig(floor=(6.0, 6.0), motor=(30.0, 30.0), contact=2000.0, seed=1)
    moved = tuple(replace(p, label=Label(session="other")) for p in loud.pinches)
    sessions = replace(loud, pinches=rig().pinches + moved)
    assert count_starts(closing_starts(sessions)) == {"rest": 24}


def test_label_overrides_the_detected_start() -> None:
    dataset = rig()
    pinch = dataset.pinches[0]
    labelled = replace(pinch, motor_start=pinch.first_sample + 40)
    assert closing_start(labelled).sample == pinch.first_sample + 40 + settling(pinch.layout)
    assert closing_start(labelled).how is StartMethod.LABEL
    # Ran already when the recording began: nothing is waited for.
    for early in (0, pinch.first_sample):
        assert closing_start(replace(pinch, motor_start=early)).sample == pinch.first_sample
    far = replace(pinch, motor_start=pinch.first_sample + len(pinch.data) - 5)
    assert closing_start(far).sample == pinch.first_sample + len(pinch.data)
    assert len(cut_closings(Dataset((far,))).pinches[0].data) == 0


def opening(closing: Closing) -> int:
    """Return the sample at which the gate opens for a closing in the whole stream."""
    return next(s for s in OPENED if closing.motor < s < closing.first)


@given(st.sampled_from(CLOSINGS), st.integers(32, 90))
def test_calibrated_start_equals_the_live_gate(closing: Closing, steps: int) -> None:
    opened = opening(closing)
    first = opened - steps * STEP  # before the motor starts, on the gate's grid
    pinch = Pinch(
        DATA[first : closing.release], LAYOUT, first_sample=first, calibration=CALIBRATION
    )
    assert closing_start(pinch) == DetectionStart(opened, StartMethod.CALIBRATION)


def test_pinch_cut_by_live_starts_at_its_first_sample() -> None:
    """Recorded pinches begin where the gate opened. Offline they must start there, too."""
    for closing in CLOSINGS:
        opened = opening(closing)
        data = DATA[opened : closing.release]
        for calibration in (CALIBRATION, None):
            pinch = Pinch(data, LAYOUT, first_sample=opened, calibration=calibration)
            assert closing_start(pinch).sample == opened
            assert waits(Dataset((pinch,))) == [0]


def test_cutting_closings_twice_changes_nothing() -> None:
    cut = cut_closings(rig())
    assert waits(cut) == [0] * 12
    for a, b in zip(cut_closings(cut).pinches, cut.pinches, strict=True):
        assert a.first_sample == b.first_sample
        assert np.array_equal(a.data, b.data)


@pytest.mark.parametrize("samples", [0, 1, 100, 700])
def test_short_pinches_start_with_their_first_sample(samples: int) -> None:
    pinches = tuple(replace(p, data=p.data[:samples], truth=()) for p in rig().pinches)
    assert waits(Dataset(pinches)) == [0] * 12
