"""Tests of random rigs and objects, with families on which the network is not trained."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from firstcontact.core.layout import ADC_COUNTS, FINGERTIP_RATE, SUBCOUNTS
from firstcontact.twin import pinch as twin_pinch
from firstcontact.twin._run import SUBSTEPS, PinchRun
from firstcontact.twin.objects import OBJECTS
from firstcontact.twin.pinch import BURN_IN
from firstcontact_lab import rigs
from firstcontact_lab.rigs import (
    FAMILIES,
    HARDEST,
    RIG_SPREAD,
    SOFTEST,
    RandomObject,
    RandomRig,
    Resonance,
    draw_block,
    draw_day,
    draw_object,
    draw_rig,
    touch,
)

BEFORE, AFTER = 0.010, 0.015


def rng(seed: int) -> np.random.Generator:
    return np.random.default_rng([31, seed])


def test_two_hundred_rigs_give_finite_signals() -> None:
    for seed in range(200):
        drawn = rng(seed)
        signal, speed = touch(
            draw_rig(drawn), draw_day(drawn), draw_object(drawn), drawn, BEFORE, AFTER
        )
        assert signal.dtype == np.int16
        assert np.ptp(signal) > 0
        assert (np.abs(signal.astype(float)) < ADC_COUNTS * SUBCOUNTS).all()
        assert 0 < speed < 2


def test_the_same_seed_gives_the_same_touch() -> None:
    def one() -> np.ndarray:
        drawn = rng(1)
        return touch(draw_rig(drawn), draw_day(drawn), draw_object(drawn), drawn, BEFORE, AFTER)[0]

    assert np.array_equal(one(), one())


def test_hard_block_is_visible_and_seldom_clipped() -> None:
    peaks = []
    for seed in range(40):
        drawn = rng(seed)
        rig, day = draw_rig(drawn), draw_day(drawn)
        signal, _ = touch(rig, day, draw_block(drawn, 60.0, 0.0), drawn, BEFORE, AFTER)
        peaks.append(np.ptp(signal.astype(float)) / (ADC_COUNTS * SUBCOUNTS))
    assert np.median(peaks) > 0.02
    assert np.mean(np.array(peaks) > 0.95) < 0.1


def _extreme(number: int) -> tuple[RandomRig, RandomObject]:
    """Return a rig three standard deviations from the mean: stiff and light, or soft and heavy."""
    drawn = rng(number)
    rig = draw_rig(drawn)
    deviation = 3 if number % 2 else -3
    light = {"phalanx_mass", "board_mass", "skin_mass", "drive_mass"}
    finger = rig.finger._replace(
        **{
            name: getattr(rig.finger, name)
            * float(np.exp(-deviation * sd if name in light else deviation * sd))
            for name, sd in RIG_SPREAD.items()
            if name.endswith("stiffness") or name in light or name == "pad_modulus"
        }
    )
    target = draw_block(drawn, HARDEST if deviation > 0 else SOFTEST, 0.0)
    return replace(rig, finger=finger), target


@pytest.mark.parametrize("number", range(4))
def test_halved_steps_change_the_waveform_of_extreme_rigs_little(
    number: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    rig, target = _extreme(number)
    waveforms = []
    for factor in (1, 2):
        run = partial(PinchRun, substeps=factor * SUBSTEPS)
        monkeypatch.setattr(twin_pinch, "PinchRun", run)
        quiet = replace(
            rig, noise=replace(rig.noise, rotor=0.0, mesh=0.0, friction=0.0, click_rate=0.0,
                               mains=0.0, hum=0.0, electronics=0.0), jitter=0.0,
        )  # fmt: skip
        drawn = rng(100 + number)
        waveforms.append(rigs.touch_volts(quiet, draw_day(drawn), target, drawn, BEFORE, AFTER)[0])
    coarse, fine = (volts[BURN_IN:] for volts in waveforms)
    assert np.isfinite(fine).all()
    assert np.abs(coarse - fine).max() < 0.01 * np.abs(fine).max()


def _drawn(seed: int) -> tuple[RandomRig, RandomObject]:
    drawn = rng(seed)
    return draw_rig(drawn), draw_object(drawn)


#: What a family is outside of: a number of its rigs or things that no training draws, with the
#: smallest and largest that training does draw in a few hundred.
OUTSIDE = {
    "linear_pad": lambda rig, target: rig.finger.pad_stiffening,
    "duller_sensor": lambda rig, target: rig.finger.buffer_cutoff * (
        rig.resonance.damping if rig.resonance else 1.0
    ),
    "silent_motor": lambda rig, target: rig.noise.rotor + rig.noise.mesh,
    "slow_closing": lambda rig, target: rig.finger.speed,
    "edge": lambda rig, target: target.parameters.radius,
    "thin_shell": lambda rig, target: (
        target.parameters.modulus * target.parameters.radius / target.parameters.dent_stiffness
    ),
    "slow_material": lambda rig, target: target.parameters.arm_relaxation,
}  # fmt: skip


@pytest.mark.parametrize("name", FAMILIES)
def test_family_is_outside_the_training_range(name: str) -> None:
    family, number = FAMILIES[name], OUTSIDE[name]
    usual = np.array([number(*_drawn(seed)) for seed in range(150)])
    family_values = []
    for seed in range(150):
        rig, target = _drawn(seed)
        family_rng = rng(seed + 1000)
        family_values.append(
            number(family.rig(rig, family_rng), family.change_object(target, family_rng))
        )
    low, high = np.quantile(usual, (0.02, 0.98))
    outside = (np.array(family_values) < low) | (np.array(family_values) > high)
    assert outside.mean() > 0.8


@pytest.mark.parametrize("name", ["tennis ball 1", "orange 1", "avocado 1"])
def test_objects_of_the_twin_lie_within_the_random_ones(name: str) -> None:
    """A slow loss is compared beside the same fast loss, and a dent among hollow objects."""
    drawn, twin = rng(5), OBJECTS[name].nominal
    targets = [draw_object(drawn).parameters for _ in range(3000)]
    if np.isfinite(twin.dent_stiffness):
        values = [o.dent_stiffness for o in targets if np.isfinite(o.dent_stiffness)]
        low, high = np.quantile(values, (0.05, 0.95))
        assert 5 * low < twin.dent_stiffness < high / 5
    else:
        near = [o for o in targets if 0.8 < o.arm_share / twin.arm_share < 1.25]
        assert np.mean([o.slow_share > twin.slow_share for o in near]) > 0.05


def test_resonance_rings_at_its_frequency_and_decays() -> None:
    step = np.zeros(4096)
    step[10:] = 1.0
    ringing = Resonance(800.0, 0.05, 0.8).apply(step) - step
    spectrum = np.abs(np.fft.rfft(ringing))
    peak = np.argmax(spectrum[50:]) + 50
    assert peak * FINGERTIP_RATE / 4096 == pytest.approx(800.0, rel=0.05)
    assert np.abs(ringing[2000:] - ringing[-1]).max() < 1e-2 * np.abs(ringing).max()
