"""The committed KiCad boards and schematics agree with the table and the layouts."""

import math
import re
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import boards
import build_boards
import circuit
import fab_files
import fingertip_layout as fingertip
import layout
import project
import pytest
from amplifier_layout import AMPLIFIER
from sexpr import Element, all_of, numbers, one_of, parse, property_of, write

LAYOUTS = {"amplifier": AMPLIFIER, "fingertip": fingertip.FINGERTIP}
#: Place of the boards on KiCad's sheet; ``write_boards.py`` cannot be imported without KiCad.
SHEET = (100.0, 70.0)
needs_kicad = pytest.mark.skipif(
    shutil.which("kicad-cli") is None or bool(build_boards.missing_packages()), reason="no KiCad 9"
)


def board_of(name: str) -> list[Element]:
    return parse((boards.FOLDER / name / f"{name}.kicad_pcb").read_text("utf-8"))


def footprint_of(board: list[Element], reference: str) -> list[Element]:
    return next(
        f for f in all_of(board, "footprint") if property_of(f, "Reference") == reference
    )  # fmt: skip


@pytest.mark.parametrize("name", boards.BOARDS)
def test_board_and_schematic_agree_with_the_table(name: str) -> None:
    assert boards.differences(boards.FOLDER, name, boards.BOARDS[name]) == []


def _other_value(board: list[Element], sheet: list[Element]) -> None:
    footprint = footprint_of(board, "R13")
    next(p for p in all_of(footprint, "property") if p[1] == "Value")[2] = "8.2k"


def _swapped_pads(board: list[Element], sheet: list[Element]) -> None:
    first, second = (one_of(pad, "net") for pad in all_of(footprint_of(board, "R12"), "pad"))
    first[1:], second[1:] = second[1:], first[1:]


def _missing_part(board: list[Element], sheet: list[Element]) -> None:
    board.remove(footprint_of(board, "C2"))


def _missing_wire(board: list[Element], sheet: list[Element]) -> None:
    sheet.remove(next(all_of(sheet, "wire")))


def _renamed_net(board: list[Element], sheet: list[Element]) -> None:
    next(label for label in all_of(sheet, "label") if label[1] == "fb_index")[1] = "fb_thumb"


def _other_number(board: list[Element], sheet: list[Element]) -> None:
    symbol = next(s for s in all_of(sheet, "symbol") if property_of(s, "Reference") == "D10")
    next(p for p in all_of(symbol, "property") if p[1] == "MPN")[2] = "BAT54S"


@pytest.mark.parametrize(
    ("fault", "reference"),
    [
        (_other_value, "R13"), (_swapped_pads, "R12"), (_missing_part, "C2"),
        (_missing_wire, "R11"), (_renamed_net, "R13"), (_other_number, "D10"),
    ],
)  # fmt: skip
def test_a_seeded_fault_is_a_difference(fault, reference: str, tmp_path: Path) -> None:
    shutil.copytree(boards.FOLDER / "amplifier", tmp_path / "amplifier")
    files = [tmp_path / f"amplifier/amplifier.{suffix}" for suffix in ("kicad_pcb", "kicad_sch")]
    board, sheet = (parse(file.read_text("utf-8")) for file in files)
    fault(board, sheet)
    for file, expression in zip(files, (board, sheet), strict=True):
        file.write_text(write(expression), "utf-8")
    found = boards.differences(tmp_path, "amplifier", circuit.parts())
    assert any(re.match(rf"{reference}\b", sentence) for sentence in found), found


def test_firmware_has_the_pins_of_the_board() -> None:
    assert boards.pin_differences() == []
    assert len(boards.read_pins()) == 14


@pytest.mark.parametrize(
    ("old", "new", "pins"),
    [
        ("{2, 3, 4}", "{2, 4, 3}", {"3", "4"}), ("{A0, A1}", "{A1, A0}", {"14", "15"}),
        ("{8, 9}", "{8, 10}", {"9", "10"}), ("{A4, A5}", "{A5, A4}", {"18", "19"}),
    ],
)  # fmt: skip
def test_another_pin_in_the_firmware_is_a_difference(
    old: str, new: str, pins: set[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    header = tmp_path / "pins.h"
    header.write_text(boards.PINS.read_text("utf-8").replace(old, new), "utf-8")
    assert {sentence.split()[1] for sentence in boards.pin_differences(header)} == pins
    monkeypatch.setattr(build_boards, "pin_differences", lambda: boards.pin_differences(header))
    monkeypatch.setattr(sys, "argv", ["build_boards.py"])
    assert build_boards.main() == 1  # make hardware stops before KiCad


@pytest.mark.parametrize("name", LAYOUTS)
def test_each_part_is_where_the_layout_has_it(name: str) -> None:
    for reference, part in boards.read_board(
        boards.FOLDER / name / f"{name}.kicad_pcb"
    ).items():  # fmt: skip
        x, y, angle = LAYOUTS[name].places[reference]
        expected = (x + SHEET[0], y + SHEET[1])
        assert part.at[:2] == pytest.approx(expected, abs=1e-3), reference
        assert (part.at[2] - angle) % 360 == 0, reference


@pytest.mark.parametrize("name", LAYOUTS)
def test_tracks_run_in_steps_of_45_degrees_and_keep_the_smallest_width(name: str) -> None:
    for segment in all_of(board_of(name), "segment"):
        (ax, ay), (bx, by) = (numbers(one_of(segment, end)) for end in ("start", "end"))
        dx, dy = abs(ax - bx), abs(ay - by)
        assert min(dx, dy, abs(dx - dy)) < 2e-3, segment
        assert numbers(one_of(segment, "width"))[0] >= layout.TRACK


@pytest.mark.parametrize("name", LAYOUTS)
def test_outline_has_the_size_of_the_layout(name: str) -> None:
    outline = next(
        r for r in all_of(board_of(name), "gr_rect") if one_of(r, "layer")[1] == "Edge.Cuts"
    )
    (ax, ay), (bx, by) = (numbers(one_of(outline, end)) for end in ("start", "end"))
    assert (bx - ax, by - ay) == pytest.approx(LAYOUTS[name].size)


def test_taxels_have_the_combs_of_the_layout() -> None:
    board = board_of("fingertip")
    for part in circuit.fingertip_parts():
        if part.kind is not circuit.Kind.TAXEL:
            continue
        row, column = int(part.pins["1"][-1]), int(part.pins["2"][-1])
        footprint = footprint_of(board, part.reference)
        place = fingertip.taxel_center(row, column)
        x, y, *angle = numbers(one_of(footprint, "at"))
        assert (x, y) == pytest.approx((place[0] + SHEET[0], place[1] + SHEET[1]), abs=1e-3)
        assert sum(angle) == 180 * column
        for pad, kind in zip(all_of(footprint, "pad"), ("row", "column"), strict=True):
            ax, ay = numbers(one_of(pad, "at"))[:2]
            polygon = one_of(one_of(pad, "primitives"), "gr_poly")
            points = [numbers(p) for p in all_of(one_of(polygon, "pts"), "xy")]
            outline = {(round(x + ax, 3), round(y + ay, 3)) for x, y in points}
            expected = fingertip.comb(kind)
            assert outline == {(round(x, 3), round(y, 3)) for x, y in expected}


def test_a_dimple_covers_nearly_the_same_gap_wherever_it_lands() -> None:
    step = fingertip.FINGER + fingertip.GAP
    lengths = [fingertip.gap_length(step * k / 12) for k in range(12)]
    assert (max(lengths) - min(lengths)) / (sum(lengths) / 12) < 0.04


def test_dimples_land_within_the_fingers() -> None:
    step = fingertip.FINGER + fingertip.GAP
    assert fingertip.FINGERS * step - fingertip.GAP > fingertip.NOMINAL.dimple_diameter + 2 * 0.5
    assert fingertip.NOMINAL.dimple_diameter + 2 * 0.5 < 2 * fingertip.OVERLAP


def test_disc_lies_between_grounds_and_far_from_the_strip() -> None:
    place = circuit.CABLE.index("disc")
    assert circuit.CABLE[place - 1] == circuit.CABLE[place + 1] == "gnd"
    distance = {wire: abs(n - place) for n, wire in enumerate(circuit.CABLE)}
    assert distance["strip"] == max(distance.values())


@pytest.mark.parametrize("house", fab_files.HOUSES)
def test_assembly_house_gets_each_placed_part_once(house: str) -> None:
    heading, *rows = fab_files.bom(house)
    references = [r for row in rows for r in row[heading.index("Designator")].split(",")]
    assert len(references) == len(set(references))
    assert set(references) == boards.placed()
    assert [len(row) for row in rows] == [len(heading)] * len(rows)
    numbers = {n: p.number for p in circuit.parts() for n in [p.reference]}
    column = next(k for k, name in enumerate(heading) if name.startswith(("Mfg", "Manufacturer P")))
    assert all(
        numbers[n] == row[column]
        for row in rows
        for n in row[heading.index("Designator")].split(",")
    )
    _, *places = fab_files.positions(house)
    assert {row[0] for row in places} == boards.placed()
    for _, x, y, side, _ in places:
        assert 0 < float(x[:-2]) < AMPLIFIER.size[0]
        assert 0 < float(y[:-2]) < AMPLIFIER.size[1]
        assert side == "Top"


def test_accessories_are_what_no_machine_places() -> None:
    names = [row[0] for row in fab_files.accessories()]
    by_hand = {p.number for p in circuit.parts() if p.number and p.kind not in boards.SMD}
    assert by_hand | {name for name, _, _ in circuit.ACCESSORIES} == set(names[1:])


def test_committed_lists_are_those_of_the_table(tmp_path: Path) -> None:
    fab_files.write_lists(tmp_path)
    for file in tmp_path.iterdir():
        assert (fab_files.FAB / file.name).read_text("utf-8") == file.read_text("utf-8"), file.name


@pytest.mark.parametrize("name", LAYOUTS)
def test_committed_gerbers_have_all_layers_and_drills(name: str) -> None:
    with zipfile.ZipFile(fab_files.FAB / f"{name}-gerbers.zip") as archive:
        texts = {n: archive.read(n).decode() for n in archive.namelist()}
    assert len([n for n in texts if n.endswith(".drl")]) == 2
    for layer in build_boards.LAYERS.split(","):
        assert any(layer.replace(".", "_") in n for n in texts), layer
    assert not any(re.search("CreationDate|DRILL file .* date", text) for text in texts.values())


def test_machine_places_the_parts_that_the_board_marks_as_surface_mounted() -> None:
    marked = {
        property_of(footprint, "Reference")
        for footprint in all_of(board_of("amplifier"), "footprint")
        if "smd" in one_of(footprint, "attr")
        and "exclude_from_pos_files" not in one_of(footprint, "attr")
    }
    assert marked == boards.placed()


def test_track_ends_with_its_diagonal_part_and_cuts_corners() -> None:
    assert layout.octilinear([(0, 0), (5, 2)]) == [(0, 0), (3, 0), (5, 2)]
    cut = layout.octilinear([(0, 0), (4, 0), (4, 4)], chamfer=1.0)
    assert cut == [(0, 0), (3, 0), (4, 1), (4, 4)]
    assert math.dist(*cut[1:3]) == pytest.approx(math.sqrt(2))


def assert_committed(folder: Path, ending: str) -> None:
    for name in LAYOUTS:
        file = f"{name}/{name}.{ending}"
        assert (folder / file).read_bytes() == (boards.FOLDER / file).read_bytes()


def test_committed_projects_are_those_that_the_script_writes(tmp_path: Path) -> None:
    project.write_projects(tmp_path)
    assert_committed(tmp_path, "kicad_pro")


def test_committed_schematics_are_those_that_the_script_writes(tmp_path: Path) -> None:
    script = Path(build_boards.HERE, "write_schematics.py")
    subprocess.run([sys.executable, script, "--out", tmp_path], check=True)
    assert_committed(tmp_path, "kicad_sch")


@needs_kicad
def test_committed_boards_are_those_that_the_script_writes(tmp_path: Path) -> None:
    script = Path(build_boards.HERE, "write_boards.py")
    subprocess.run([build_boards.KICAD_PYTHON, script, "--out", tmp_path], check=True)
    assert_committed(tmp_path, "kicad_pcb")


def test_another_version_of_kicad_fails(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    program = tmp_path / "kicad-cli"
    program.write_text("#!/bin/sh\necho 6.0.11\n")
    program.chmod(0o755)
    monkeypatch.setenv("PATH", str(tmp_path), prepend=":")
    monkeypatch.setattr(sys, "argv", ["build_boards.py"])
    assert "6.0.11" in build_boards.missing_packages()
    assert build_boards.main() == 1


@needs_kicad
@pytest.mark.parametrize("name", LAYOUTS)
def test_kicad_finds_no_fault(name: str) -> None:
    assert build_boards.faults(boards.FOLDER / name, name) == []


@needs_kicad
def test_kicad_finds_each_seeded_fault() -> None:
    build_boards.selftest(boards.FOLDER / "amplifier")
