"""The force array as a network, the closed form that solves it."""

import circuit
import numpy as np
import pytest
import taxels
from hypothesis import given
from hypothesis import strategies as st
from taxels import SHEET, Method

from firstcontact.core.board import DIVIDER_OHM, PIN_OHM, ROW_OHM
from firstcontact.core.calibration import ForceCurve
from firstcontact.core.layout import ADC_VOLTS

loads = st.lists(st.floats(0.0, 12.0), min_size=6, max_size=6)


def in_siemens(volts: np.ndarray) -> np.ndarray:
    """Return the conductance of each taxel if it were alone in its column, S."""
    return volts / (ADC_VOLTS - volts) / SHEET.resistor


def test_twin_calibration_and_board_have_the_same_resistors() -> None:
    values = {p.reference: p.value for p in circuit.parts()}
    assert {values[f"R{n}"] for n in (17, 18, 27, 28)} == {SHEET.resistor} == {DIVIDER_OHM}
    assert {values[f"R{n}"] for n in (30, 31, 32, 40, 41, 42)} == {ROW_OHM}
    assert SHEET.row == ROW_OHM + PIN_OHM
    assert ForceCurve(0, 0.0, 1.0, 1.0, 0.0).resistor == DIVIDER_OHM


@given(loads)
def test_columns_of_grounded_rows_are_solved_exactly(forces: list[float]) -> None:
    g = taxels.conductances(forces)
    volts = taxels.readings(g, Method.SOLVED, series=1e-6)
    columns = g.reshape(3, 2).sum(axis=0)
    expected = ADC_VOLTS * g / (1 / SHEET.resistor + np.tile(columns, 3))
    assert volts == pytest.approx(expected)
    assert in_siemens(taxels.alone(volts)) == pytest.approx(g, rel=1e-5)


@given(loads)
def test_pins_change_a_loaded_taxel_by_less_than_two_percent(forces: list[float]) -> None:
    g = taxels.conductances(forces)
    solved = in_siemens(taxels.alone(taxels.readings(g, Method.SOLVED, series=PIN_OHM)))
    assert solved == pytest.approx(g, rel=0.02, abs=0.05 * SHEET.leak + 0.003 * g.max())


def test_resistors_of_rows_change_both_loaded_taxels_of_a_row_by_eight_percent() -> None:
    g = taxels.conductances([6, 6, 0, 0, 0, 0])
    solved = in_siemens(taxels.alone(taxels.readings(g, Method.SOLVED)))
    assert solved[:2] / g[:2] == pytest.approx(0.92, abs=0.01)


def test_floating_rows_show_load_at_the_fourth_corner_of_a_rectangle() -> None:
    # Two loaded taxels in series with a third lead from the driven row to the column.
    g = taxels.conductances([0, 3, 3, 3, 0, 0])
    floating = in_siemens(taxels.readings(g, Method.FLOATING, series=1e-6))
    assert floating[0] / g[0] == pytest.approx(7.0, abs=0.1)


def test_floating_rows_of_two_by_two_have_the_closed_form(monkeypatch: pytest.MonkeyPatch) -> None:
    # The third row hardly conducts. Dividers of 1 GOhm draw the same current i from both columns.
    monkeypatch.setattr(taxels, "SHEET", SHEET._replace(resistor=1e9))
    a, b, c, d = 1e-5, 2e-5, 3e-5, 4e-5
    volts = taxels.readings(np.array([a, b, c, d, 0, 0]) + 1e-12, Method.FLOATING, series=0.1)
    i = ADC_VOLTS / 1e9
    own = i / (a + 1 / (1 / b + 1 / d + 1 / c))  # through a, beside b, d and c in series
    detour = 1 / (1 / a + 1 / c + 1 / d)
    other = i * detour / (b + detour) / a  # part of the other column's current that goes through a
    assert ADC_VOLTS - volts[0] == pytest.approx(own + other, rel=1e-3)


def test_build_page_has_the_resistances_of_the_unloaded_sheet() -> None:
    page = (taxels.PAGE.parents[1] / "how-to/build-a-fingertip.md").read_text("utf-8")
    # All six taxels are equal: between rows lead two columns, between columns three rows.
    assert 1 / SHEET.leak * 2 / taxels.COLUMNS == pytest.approx(500e3)
    assert 1 / SHEET.leak * 2 / taxels.ROWS == pytest.approx(330e3, rel=0.02)
    assert "the twin has 500 kΩ" in page
    assert "the twin has 330 kΩ" in page
