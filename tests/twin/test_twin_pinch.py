"""Tests of the published statistics of pinches, and of excerpts around their contacts."""

from dataclasses import replace
from functools import cache
from itertools import pairwise

import numpy as np
import pytest
from pinches import BRITTLE, EVERYDAY, PAPER_RIG, drawn, simulated

from firstcontact.core import Label, Pinch, fingertip_layout
from firstcontact.core.layout import FINGERTIP_RATE
from firstcontact.twin import BLOCKS, CONDITIONS, simulate_pinch
from firstcontact.twin.draw import Condition, PinchDraw
from firstcontact.twin.mechanics import BUFFER
from firstcontact.twin.objects import EVERYDAY_OBJECTS
from firstcontact.twin.pinch import PinchJob, excerpt, integrate_pinch, simulate_pinches

LAYOUT = fingertip_layout()
WINDOW = round(0.015 * LAYOUT.rate)


@cache
def pinches(condition: Condition = PAPER_RIG, per_block: int = 60) -> tuple[Pinch, ...]:
    """Return this number of pinches of every block."""
    return tuple(simulated(kind, i, condition) for kind in BLOCKS for i in range(per_block))


def test_strips_close_at_the_drawn_contacts() -> None:
    for number in range(20):
        timing = drawn(BLOCKS[2], number).timing
        pinch = simulated(BLOCKS[2], number)
        assert pinch.second is not None
        assert (pinch.first.finger == 0) == timing.first_is_index
        for contact, instant in zip(pinch.truth, timing[:2], strict=True):
            late = contact.sample / LAYOUT.rate - instant
            assert -0.05e-3 < late < 1.05 / LAYOUT.rate, "the first sample after it touched"
            assert contact.decided == contact.sample


@pytest.mark.parametrize("condition", [PAPER_RIG, EVERYDAY], ids=lambda c: c.name)
def test_force_is_silent_until_the_second_contact(condition: Condition) -> None:
    rises = []
    for pinch in pinches(condition, 20):
        force = pinch.force(pinch.first.finger).sum(axis=1)
        start = pinch.first.sample
        stop = min(pinch.second.sample, start + WINDOW)
        baseline = force[:start].mean()
        grip = force[-50:].mean() - baseline
        assert grip > 1.0, "both fingers squeeze in the end"
        rises.append((force[start : stop + 1].max() - baseline) / grip)
    assert np.median(rises) < 0.01
    assert np.percentile(rises, 95) < 0.05


def peaks(condition: Condition) -> np.ndarray:
    """Return the largest piezo deflections within 15 ms, V, shape (blocks, pinches)."""
    out = []
    for pinch in pinches(condition):
        start = pinch.first.sample
        piezo = pinch.vibration()[:, pinch.first.finger]
        window = piezo[start : start + WINDOW]
        if pinch.second is not None:
            window = window[: max(pinch.second.sample - start, 1)]
        out.append(np.abs(window - piezo[:start].mean()).max())
    return np.array(out).reshape(len(BLOCKS), -1)


def test_the_piezo_peak_rises_about_in_proportion_to_shore_a() -> None:
    medians = np.median(peaks(PAPER_RIG), axis=1)
    assert (np.diff(medians) > 0).all()
    shore = [kind.shore_a for kind in BLOCKS]
    assert np.corrcoef(shore, medians)[0, 1] > 0.97


def test_peak_alone_does_not_separate_the_blocks() -> None:
    # A twin in which it does is too easy.
    block_peaks = peaks(EVERYDAY)
    overlap = [a.max() > b.min() for a, b in pairwise(block_peaks)]
    assert all(overlap)


def test_pinch_has_the_device_format_and_a_contact_above_its_noise() -> None:
    for pinch in pinches():
        assert pinch.layout == LAYOUT
        assert pinch.data.dtype == np.int16
        assert len(pinch.data) >= 0.3 * LAYOUT.rate
        assert 0 <= pinch.data.min() <= pinch.data[:, :14].max() <= 1023 * 32
        piezo = pinch.vibration()[:, pinch.first.finger]
        quiet = piezo[: pinch.first.sample].std()
        touched = np.abs(piezo[pinch.first.sample :] - piezo[: pinch.first.sample].mean()).max()
        assert 0.002 < quiet < 0.1
        assert touched > 5 * quiet


def test_pinches_simulated_together_are_those_simulated_alone() -> None:
    kinds = (BLOCKS[0], BLOCKS[4], BRITTLE[0]) * 3
    jobs = [PinchJob(drawn(kind, i), Label(kind.name), 7 * i) for i, kind in enumerate(kinds)]
    made = list(simulate_pinches(jobs, 0.2))
    assert len(made) == len(jobs)
    for i, together in enumerate(made):
        alone = simulate_pinch(drawn(kinds[i], i), jobs[i].label, 7 * i, duration=0.2)
        assert together.data.tobytes() == alone.data.tobytes()
        assert (together.truth, together.label) == (alone.truth, alone.label)
        at_zero = simulate_pinch(drawn(kinds[i], i), jobs[i].label, duration=0.2)
        assert [c.sample - 7 * i for c in alone.truth] == [c.sample for c in at_zero.truth]


BEFORE, DURATION = 0.04, 0.06


def silent(draw: PinchDraw) -> PinchDraw:
    """Return the draw without noise and jitter, with its contact at a sampling instant."""
    quiet = tuple(
        replace(n, rotor=0.0, mesh=0.0, friction=0.0, click_rate=0.0, mains=0.0) for n in draw.noise
    )
    first_contact = round(draw.timing.first * FINGERTIP_RATE) / FINGERTIP_RATE
    second_contact = first_contact + draw.timing.second - draw.timing.first
    timing = draw.timing._replace(first=first_contact, second=second_contact)
    return replace(draw, noise=quiet, jitter=0.0, timing=timing)


@pytest.mark.parametrize("condition", CONDITIONS.values(), ids=lambda c: c.name)
def test_excerpt_has_the_waveform_of_the_full_pinch(condition: Condition) -> None:
    for number, kind in enumerate((BLOCKS[0], BLOCKS[-1], *EVERYDAY_OBJECTS[::3])):
        draw = silent(drawn(kind, number, condition))
        _, waveform = integrate_pinch(draw)
        lead = round(BEFORE * FINGERTIP_RATE) / FINGERTIP_RATE
        _, part = integrate_pinch(excerpt(draw, lead), duration=DURATION)
        start = round((draw.timing.first - lead) * FINGERTIP_RATE)
        expected = waveform[start : start + len(part), :, BUFFER]
        error = np.abs(part[:, :, BUFFER] - expected).max() / np.abs(expected).max()
        # What is left is how far the vibration had settled.
        assert error < 1e-3
