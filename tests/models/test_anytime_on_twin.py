"""The network on the twin: conditioning narrows intervals, and odd signals are marked.

The tests check properties that any useful network has, not numbers of the current one.
"""

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest

from firstcontact.core.layout import ADC_VOLTS
from firstcontact.core.layout import FINGERTIP_RATE as RATE
from firstcontact.models import Predictions, Touches
from firstcontact.models.model_file import pretrained
from firstcontact.models.rig.rig_model import RigModel
from firstcontact.models.rig.rigs import Rig
from firstcontact.models.values import Values
from firstcontact.signal import samples_in
from firstcontact.twin import CONDITIONS
from firstcontact_lab.study.rig_sets import PinchUse, RigSet, Sizes, rig_set
from ringing import LONGEST, SHORTEST

SIZES = Sizes(blocks=12, held_out=6, objects=6, other_blocks=1, kinds=1)
NAMES = list(CONDITIONS)
TIMES = (10, 15, 25, 39, 74)


@cache
def made(name: str) -> RigSet:
    return rig_set(77, CONDITIONS[name], SIZES, [0, 1, 2, 3])


@cache
def knowing(name: str) -> RigModel:
    rig_set = made(name)
    blocks = rig_set.indices(PinchUse.BLOCKS)
    rig = Rig.fit(rig_set.touches.take(blocks), rig_set.windows.y[blocks])
    return pretrained().conditioned_on({Rig.ANY: rig})


def objects(name: str, lasting: int = SHORTEST) -> tuple[Touches, Values]:
    rig_set = made(name)
    rows = np.concatenate([rig_set.indices(PinchUse.HELD), rig_set.indices(PinchUse.OBJECTS)])
    rows = rows[rig_set.touches.valid[rows] >= lasting]
    return rig_set.touches.take(rows), rig_set.windows.y[rows]


def width(answers: Predictions) -> float:
    return float(np.mean(answers.high - answers.low))


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("samples", TIMES)
def test_intervals_lie_on_the_scale_around_their_answers(name: str, samples: int) -> None:
    answers = knowing(name).predict_touches(objects(name)[0].until(samples))
    assert (answers.low >= 0).all()
    assert (answers.high <= 100).all()
    assert ((answers.low <= answers.value) & (answers.value <= answers.high)).all()
    assert (answers.spread > 0).all()


@pytest.mark.parametrize("name", NAMES)
def test_a_rig_that_is_not_known_has_wider_intervals(name: str) -> None:
    touches, truth = objects(name)
    conditioning, unknown = (
        knowing(name).predict_touches(touches),
        pretrained().predict_touches(touches),
    )
    assert width(unknown) > 1.2 * width(conditioning)
    error, blind = (np.mean((a.value - truth) ** 2) for a in (conditioning, unknown))
    assert error < blind


@pytest.mark.parametrize("name", NAMES)
def test_most_truths_lie_in_their_intervals(name: str) -> None:
    """The bound is far below the nominal level, because coverage is defined over many rigs."""
    touches, truth = objects(name)
    for samples in TIMES:
        answers = knowing(name).predict_touches(touches.until(samples))
        assert np.mean((answers.low <= truth) & (truth <= answers.high)) > 0.7


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("samples", [*TIMES, 20, 45, 62, 70])  # at stages, and between them
def test_the_twins_own_contacts_are_rarely_strange(name: str, samples: int) -> None:
    assert (
        knowing(name).predict_touches(objects(name)[0].until(samples)).out_of_range.mean() <= 0.05
    )


def _dead(signals: np.ndarray, lead: int, level: float) -> None:
    signals[:] = np.random.default_rng(1).normal(0, 1e-4, signals.shape)


def _silent(signals: np.ndarray, lead: int, level: float) -> None:
    """Return signals with the motor's noise and no contact."""
    signals[:, lead:] = signals[:, : signals.shape[1] - lead]


def _saturated(signals: np.ndarray, lead: int, level: float) -> None:
    end = 0.5 * ADC_VOLTS
    signals[:, lead:] = np.clip(1e3 * signals[:, lead:], -end, end)


def _slip(signals: np.ndarray, lead: int, level: float) -> None:
    """Return signals with friction from 2 ms after the contact on, a third as loud."""
    rubbed = signals[:, lead + SHORTEST :]
    rubbed += np.random.default_rng(3).normal(0, level / 3, rubbed.shape)


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize(
    ("fault", "least"),
    [
        (_dead, 0.95),
        (_silent, 0.95),
        (_saturated, 0.95),
        (_slip, 0.5),
    ],
)
@pytest.mark.parametrize("samples", [25, 39, 74])
def test_what_is_like_nothing_is_strange(
    name: str, fault: Callable[[np.ndarray, int, float], None], least: float, samples: int
) -> None:
    touches, _ = objects(name)
    signals = touches.signals.astype(np.float64)
    fault(signals, touches.lead, knowing(name).rigs[Rig.ANY].level)
    valid_lengths = np.full(len(touches), LONGEST)
    faulty = replace(touches, signals=signals.astype(np.float32), valid=valid_lengths)
    assert knowing(name).predict_touches(faulty.until(samples)).out_of_range.mean() >= least


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("gain", [0.1, 1.0, 5.0])
@pytest.mark.parametrize("samples", TIMES)
def test_a_model_that_knows_no_rig_rarely_calls_a_touch_strange(
    name: str, gain: float, samples: int
) -> None:
    """Without a known rig, predictions do not depend on the gain."""
    touches, _ = objects(name)
    louder = replace(touches, signals=np.float32(gain) * touches.signals)
    assert pretrained().predict_touches(louder.until(samples)).out_of_range.mean() <= 0.05


def foreign(make: Callable[[np.ndarray, np.random.Generator], np.ndarray]) -> Touches:
    """Return signals that begin quietly and contain no touch, with peaks from 0.03 to 1.5 V."""
    rng, n = np.random.default_rng(11), 100
    lead, tail = samples_in(Touches.BEFORE, RATE), LONGEST
    t = np.arange(tail) / RATE
    signals = 0.003 * rng.standard_normal((n, lead + tail))
    signals[:, lead:] += [make(t, rng) for _ in range(n)]
    signals *= np.exp(rng.uniform(np.log(0.03), np.log(1.5), n))[:, None]
    nothing = np.full(n, np.nan)
    numbers = np.full(n, LONGEST, np.intp), np.zeros(n, np.intp)
    return Touches(signals.astype(np.float32), *numbers, nothing, nothing, nothing, RATE)


def sine(frequency: float, decay: float = np.inf) -> Any:
    def made(t: np.ndarray, rng: np.random.Generator) -> np.ndarray:
        return np.sin(2 * np.pi * frequency * t) * np.exp(-t / decay)

    return made


def hiss(t: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    return rng.standard_normal(len(t)) / 3


@pytest.mark.parametrize("name", [*NAMES, "no rig"])
@pytest.mark.parametrize(
    "make", [sine(300.0), sine(700.0), sine(1900.0), sine(500.0, 0.01), sine(1500.0, 0.005), hiss]
)
def test_a_signal_unlike_a_touch_is_strange(name: str, make: Any) -> None:
    model = pretrained() if name == "no rig" else knowing(name)
    for samples in TIMES[2:]:  # the first half of a wave looks like a touch
        assert model.predict_touches(foreign(make).until(samples)).out_of_range.mean() >= 0.95
