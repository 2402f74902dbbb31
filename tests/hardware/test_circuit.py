"""The amplifier board's table, the build page made from it, and its simulation in ngspice."""

from __future__ import annotations

import math
import shutil
from collections import Counter

import circuit
import disc
import pytest
import simulate
import spice
import write_page

from firstcontact.twin.mechanics import FingerParameters

needs_ngspice = pytest.mark.skipif(shutil.which("ngspice") is None, reason="no ngspice")


def test_page_has_the_tables_of_the_circuit() -> None:
    page = write_page.PAGE.read_text(encoding="utf-8")
    assert write_page.filled(page, write_page.read_results()) == page


def test_each_reference_is_unique_and_no_net_ends_at_one_pin() -> None:
    parts = circuit.parts()
    assert len({part.reference for part in parts}) == len(parts)
    nets = Counter(net for part in parts for net in part.pins.values())
    # The fourth amplifier feeds itself.
    assert all(count >= 2 for count in nets.values())


def test_the_stored_results_agree_with_the_twin() -> None:
    simulate.check(write_page.read_results())


@needs_ngspice
def test_the_stored_results_are_those_of_the_circuit() -> None:
    stored, new = write_page.read_results(), simulate.measure(boards=3, seed=1)
    for name in ("gain", "low_hz", "high_hz", "noise_volts", "amplifier_offset_counts"):
        assert getattr(new, name) == pytest.approx(getattr(stored, name), rel=0.01), name
    assert new.sound_hz == pytest.approx(stored.sound_hz, rel=0.01)
    simulate.check(new)


@needs_ngspice
@pytest.mark.parametrize(("reference", "factor"), [("R13", 2.0), ("R10", 0.1), ("C10", 10.0)])
def test_a_wrong_part_fails_the_check(reference: str, factor: float) -> None:
    value = next(part.value for part in circuit.parts() if part.reference == reference)
    response = simulate.response(values={reference: factor * value})
    results = write_page.read_results()
    wrong = dict(zip(simulate.RESPONSE, response, strict=True))
    with pytest.raises(AssertionError):
        simulate.check(type(results)(**{**vars(results), **wrong}))


@needs_ngspice
def test_gain_of_an_ideal_amplifier_is_that_of_its_resistors() -> None:
    # 1 GOhm at the input and 1 pF at the output leave only the two resistors of the gain.
    gain, _, _ = simulate.response(values={"R10": 1e9, "C10": 1e-12})
    assert gain == pytest.approx(1 + 82 / 3.9, rel=0.005)


def test_pressed_disc_gives_the_volts_per_newton_of_the_twin() -> None:
    assert disc.pressed() == pytest.approx(FingerParameters().piezo_volts_per_newton)


def test_bent_board_of_an_infinite_strip(monkeypatch: pytest.MonkeyPatch) -> None:
    # A long board with 1 N per its own area bends to the parabola of a beam: the curvature in the
    # middle is q b^2 / (8 D), and a small disc there stretches by it.
    monkeypatch.setattr(disc, "LENGTH", 0.6)
    monkeypatch.setattr(disc, "RADIUS", 1e-4)
    monkeypatch.setattr(disc, "DISC_THICKNESS", 1e-9)  # too thin to stiffen the board
    fr4 = disc.Fr4()
    rigidity = fr4.modulus * disc.THICKNESS**3 / (12 * (1 - fr4.poisson**2))
    strain = disc.WIDTH / (8 * rigidity * disc.LENGTH) * disc.THICKNESS / 2
    charge = disc.D31 * disc.PZT_MODULUS / (1 - disc.PZT_POISSON) * strain * math.pi * 1e-8
    assert disc.bent(terms=999) == pytest.approx(charge / disc.CAPACITANCE, rel=0.01)


def test_bending_depends_on_the_place_of_the_force_and_pressing_does_not() -> None:
    assert disc.bent() == pytest.approx(0.36, rel=0.05)
    assert disc.bent(1e-3) > 2.5 * disc.bent()


@needs_ngspice
def test_a_net_without_ground_is_an_error() -> None:
    with pytest.raises(RuntimeError, match="ngspice"):
        spice.simulate(["I1 0 a 1", "C1 a 0 1n"], "op", "v(a)")
