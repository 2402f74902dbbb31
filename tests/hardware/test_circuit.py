"""The amplifier board's table, the build page made from it, and its simulation in ngspice."""

import math
import re
import shutil
from collections import Counter
from dataclasses import replace

import circuit
import multimeter_tables
import numpy as np
import pytest
import simulate
import spice
import taxels
import write_page

needs_ngspice = pytest.mark.skipif(shutil.which("ngspice") is None, reason="no ngspice")


def test_pages_have_the_tables_of_the_hardware() -> None:
    texts = [page.read_text("utf-8") for page in (write_page.BUILD, write_page.CIRCUIT)]
    results = write_page.read_results()
    assert [write_page.filled(text, results) for text in texts] == texts
    names = re.findall(r"<!-- hardware: (\w+) -->", "".join(texts))
    assert " ".join(sorted(names)) == (
        "accessories discs fit gluings order parts pins pour print resistors simulation"
    )


def test_resistance_of_a_network_with_a_loop_and_of_parts_that_do_not_meet(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    triangle = (("a", "b", 1e3), ("b", "c", 2e3), ("a", "c", 3e3), ("d", "e", 4e3))
    resistors = {
        str(n): circuit.Part(str(n), circuit.Kind.RESISTOR, {"1": a, "2": b}, "", value)
        for n, (a, b, value) in enumerate(triangle)
    }
    monkeypatch.setattr(multimeter_tables, "PARTS", resistors)
    assert multimeter_tables.resistance("a", "c") == pytest.approx(1.5e3)
    assert multimeter_tables.resistance("a", "d") == math.inf


def test_reading_through_u1_lies_between_a_short_and_nothing() -> None:
    # 470 kOhm beside both resistors of 10 kOhm, when U1 connects its input with the reference.
    assert multimeter_tables.through_u1("disc_index", "vref") == "19.2 kΩ to 470 kΩ"
    assert multimeter_tables.through_u1("disc_index", "clamp_index") == "the same"
    assert multimeter_tables.through_u1("index_row_0", "index_line_0") == "the same"
    assert multimeter_tables.through_u1("out_thumb", "fb_thumb") == "0 Ω to 33 kΩ"


def test_page_names_the_legs_of_the_amplifier_that_are_connected_side_by_side() -> None:
    u1 = multimeter_tables.PARTS["U1"].pins
    pairs = [n for n in (*range(1, 7), *range(8, 14)) if u1[str(n)] == u1[str(n + 1)]]
    assert pairs == [8, 13]
    assert "only 8 and 9, and 13 and 14, are connected" in write_page.BUILD.read_text("utf-8")


@needs_ngspice
@pytest.mark.parametrize("reference", [*simulate.WRONG, "R23", "R27", "R32"])
def test_a_wrong_part_fails_the_check(reference: str) -> None:
    factor = simulate.WRONG.get(reference, 0.5)
    assert simulate.is_found(write_page.read_results(), reference, factor)


@pytest.mark.parametrize(
    ("wrong", "sentence"), [({"resistor": 4.7e3}, "at 2 N"), ({"row": 56.0}, "in connected rows")]
)
def test_a_wrong_value_in_the_one_table_fails_the_check(
    monkeypatch: pytest.MonkeyPatch, wrong: dict[str, float], sentence: str
) -> None:
    for module in (simulate, taxels):
        monkeypatch.setattr(module, "SHEET", taxels.SHEET._replace(**wrong))
    loaded = [simulate.TAXEL] * 2 + [0.0] * 4
    volts = taxels.readings(np.array(loaded), taxels.Method.GROUNDED)[0]
    amperes = 3.3 / (2 * taxels.SHEET.row)
    results = replace(
        write_page.read_results(), force_volts=[volts] * 12, short_amperes=(amperes, amperes)
    )
    with pytest.raises(AssertionError, match=sentence):
        simulate.check(results)


@needs_ngspice
@pytest.mark.parametrize("reference", ["R11", "R12", "R16", "R22", "C2"])
def test_parts_that_only_protect_do_not_change_the_signal(reference: str) -> None:
    value = next(part.value for part in circuit.parts() if part.reference == reference)
    results = write_page.read_results()
    for factor in (0.1, 10.0):
        new = simulate.changed(results, {reference: factor * value})
        assert (new.gain, new.low_hz, new.high_hz, *new.thumb) == pytest.approx(
            (results.gain, results.low_hz, results.high_hz, *results.thumb), rel=0.02
        )


@needs_ngspice
def test_readings_are_ratios_to_a_supply_with_ripple() -> None:
    # The reference of 1.65 V is steady at 1 kHz, so the reading moves by half of the ripple.
    counts = 2 * 0.5 * 10e-3 / spice.COUNT
    assert simulate.ripple() == pytest.approx(counts, rel=0.02)


@needs_ngspice
def test_connected_rows_carry_the_current_of_their_resistors() -> None:
    assert simulate.short_current() == pytest.approx([3.3 / (2 * (330 + 23))] * 2, rel=1e-3)
    without = {p.reference: 1e-3 for p in circuit.parts() if p.purpose.startswith("protects the p")}
    assert simulate.short_current(values=without) == pytest.approx([72e-3] * 2, rel=0.01)


@needs_ngspice
def test_second_reading_of_a_column_is_free_of_the_piezos_charge() -> None:
    first, second = simulate.carries()
    assert second < 0.05 < 2 < first < 5


def test_drawing_shows_the_values_of_the_table() -> None:
    drawing = (write_page.ROOT / "docs/images/fingertip-circuit.svg").read_text("utf-8")
    shown = set(re.findall(r"[\d.]+ [kµn]?[ΩF]", drawing)) - {"5.9 nF"}  # the disc
    units = {circuit.Kind.RESISTOR: "Ω", circuit.Kind.CAPACITOR: "F"}
    table = {
        re.sub(r"([\d.]+)(\D?)", r"\1 \2", part.label, count=1).replace("u", "µ") + units[part.kind]
        for part in circuit.parts()
        if part.kind in units
    }
    assert shown == table
    wires = (wire.replace("_", " ") for wire in circuit.CABLE)
    assert f"Cable, pins 1 to 9: {', '.join(wires)}" in drawing


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
def test_gain_of_an_ideal_amplifier_is_that_of_its_resistors() -> None:
    # 1 GOhm at the input and 1 pF at the output leave only the two resistors of the gain.
    gain, _, _ = simulate.response(values={"R10": 1e9, "C10": 1e-12})
    assert gain == pytest.approx(1 + 33 / 5.1, rel=0.005)


@needs_ngspice
def test_a_net_without_ground_is_an_error() -> None:
    with pytest.raises(RuntimeError, match="ngspice"):
        spice.simulate(["I1 0 a 1", "C1 a 0 1n"], "op", "v(a)")
