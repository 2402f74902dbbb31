"""Detectors find the same contacts if a pinch begins before its motor starts."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from firstcontact.contact import SvmDetector, ThresholdDetector
from firstcontact.contact.closing_start import closing_starts, count_starts
from firstcontact.core import ChannelKind, Dataset, Pinch
from firstcontact.signal import ExponentialSmoothing
from firstcontact.twin import draw_pinch, simulate_pinch
from firstcontact.twin.draw import condition
from firstcontact.twin.simulation import plan_sessions
from firstcontact_lab.study.detection_scores import score_detector

#: Share of windows or pinches that may differ: one or two of those here.
NEAR = 0.02
CONDITIONS = ("paper-rig", "everyday")


#: RMS of electronics and amplitude of hum of the twin, V.
ELECTRONICS, HUM = 0.0022, 0.0015


def rested(
    dataset: Dataset,
    rest_range: tuple[float, float] = (0.05, 0.4),
    electronics: float = ELECTRONICS,
    jerk: float = 0.03,
    seed: int = 0,
) -> Dataset:
    """Return the pinches with some seconds of rest before them.

    During rest there are only noise and hum of the electronics, because the motor does not run.

    The motor starts with a jerk of ``jerk`` V, and reaches its full loudness within 20 ms.
    """
    rng = np.random.default_rng(seed)
    return replace(
        dataset,
        pinches=tuple(
            _prepend_quiet(
                p, round(rng.uniform(*rest_range) * p.layout.rate), electronics, jerk, rng
            )
            for p in dataset.pinches
        ),
    )


def _prepend_quiet(
    pinch: Pinch, n: int, electronics: float, jerk: float, rng: np.random.Generator
) -> Pinch:
    layout, rate = pinch.layout, pinch.layout.rate
    motor = pinch.data.astype(np.float64)
    prefix = np.repeat(motor[:1], n, axis=0)
    growing = round(0.02 * rate)
    ramp = np.linspace(0.0, 1.0, growing)
    t = np.arange(len(motor)) / rate
    for column in layout.columns(ChannelKind.VIBRATION):
        volt, zero = 1.0 / layout.channels[column].scale, layout.channels[column].offset
        white = electronics * rng.standard_normal((n + growing, 1))
        hum = HUM * np.sin(2 * np.pi * 50 * np.arange(n + growing) / rate + rng.uniform(0, 6))
        noise = ExponentialSmoothing(0.5).update(white)[:, 0] + hum * (electronics > 0)
        prefix[:, column] = zero + volt * noise[:n]
        start = ramp * (motor[:growing, column] - zero) + volt * (1 - ramp) * noise[n:]
        motor[:growing, column] = zero + start
        sign = rng.choice([-1.0, 1.0])
        motor[:, column] += sign * volt * jerk * np.exp(-t / 0.004) * np.sin(2 * np.pi * 180 * t)
    data = np.concatenate([prefix, motor])
    if pinch.data.dtype.kind == "i":
        data = np.rint(data.clip(0, 32736))
    truth = tuple(replace(c, sample=c.sample + n, decided=c.decided + n) for c in pinch.truth)
    return replace(pinch, data=data.astype(pinch.data.dtype), truth=truth)


@cache
def twin(name: str) -> Dataset:
    """Return pinches whose motor runs from the first sample on, as `simulate` makes them."""
    pinches = []
    for session in plan_sessions(condition(name), 20, 0, 3):
        for number, planned in enumerate(session.pinches):
            draw = draw_pinch(3, condition(name), session.name, planned.specimen, number)
            pinches.append(simulate_pinch(draw, planned.label, 2000 * len(pinches)))
    return Dataset(tuple(pinches), "twin")


@cache
def rested_twin(name: str) -> Dataset:
    return rested(twin(name))


def halves(dataset: Dataset) -> tuple[Dataset, Dataset]:
    """Split the sessions into training and test data."""
    even = np.isin(dataset.sessions, np.unique(dataset.sessions)[::2])
    return dataset.take(even), dataset.take(~even)


@pytest.mark.parametrize("name", CONDITIONS)
@pytest.mark.parametrize("rest_range", [(0.05, 0.06), (0.05, 0.4)])
def test_closings_after_rest_start_after_it(name: str, rest_range: tuple[float, float]) -> None:
    dataset = rested(twin(name), rest_range)
    starts = closing_starts(dataset)
    assert count_starts(starts) == {"rest": len(starts)}
    delays = [
        (pinch.first.sample - start.sample) / pinch.layout.rate
        for start, pinch in zip(starts, dataset.pinches, strict=True)
    ]
    # Heard some 40 ms after its start; a motor that is hardly heard, a little later.
    assert np.mean(np.array(delays) > 0.06) >= 1 - NEAR
    assert max(delays) < 0.13


@pytest.mark.parametrize("name", CONDITIONS)
def test_rest_does_not_change_the_threshold_score(name: str) -> None:
    without_rest = score_detector(ThresholdDetector(), halves(twin(name))[1])
    after_rest = score_detector(ThresholdDetector(), halves(rested_twin(name))[1])
    assert after_rest.window_accuracy == pytest.approx(without_rest.window_accuracy, abs=NEAR)
    assert after_rest.too_soon == 0


@pytest.mark.parametrize("training_kind", ["plain", "rest"])
def test_svm_transfers_between_rigs_with_and_without_quiet_lead(training_kind: str) -> None:
    kinds = {"plain": twin("everyday"), "rest": rested_twin("everyday")}
    detector = SvmDetector().fit(halves(kinds[training_kind])[0])
    scores = {k: score_detector(detector, halves(d)[1]).pinch_success for k, d in kinds.items()}
    assert min(scores.values()) >= 0.95
    assert scores["plain"] == pytest.approx(scores["rest"], abs=NEAR)
