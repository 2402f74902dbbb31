"""Write the boards, check them with KiCad, and make the files for the board house.

python hardware/build_boards.py             # everything, into hardware/out
python hardware/build_boards.py --selftest  # puts a fault into a copy for each check
"""

from __future__ import annotations

import argparse
import csv
import json
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

from boards import BOARDS, pin_differences
from fab_files import FAB, positions, write_lists, write_zip
from sexpr import Element, all_of, numbers, one_of, parse, property_of, write

HERE = Path(__file__).resolve().parent
OUT = HERE / "out"
IMAGES = HERE.parent / "docs/images"
#: Python that has KiCad's module.
KICAD_PYTHON = "/usr/bin/python3"
LAYERS = "F.Cu,B.Cu,F.Mask,B.Mask,F.Silkscreen,B.Silkscreen,F.Paste,Edge.Cuts"


def missing_packages() -> str:
    """Return a sentence that says what to install; "" if KiCad 9 is there."""
    command = shutil.which("kicad-cli")
    version = _run("kicad-cli", "version").strip() if command else ""
    footprints = Path("/usr/share/kicad/footprints")
    if version.startswith("9.") and footprints.is_dir():
        return ""
    return (
        f"hardware/boards stays as it is: KiCad 9 is needed, and {version or 'none'} was found. "
        "hardware/install-kicad installs it on Debian 12"
    )


def _run(*command: str | Path) -> str:
    process = subprocess.run(
        [str(word) for word in command], capture_output=True, text=True, check=False
    )
    if process.returncode:
        raise RuntimeError(f"{command} failed:\n{process.stdout}{process.stderr}")
    return process.stdout


def erc(schematic: Path) -> list[str]:
    """Return the violations of KiCad's electrical rules in a schematic, a sentence each."""
    report = _report("sch", "erc", "--severity-all", schematic)
    return [text for sheet in report["sheets"] for text in _sentences(sheet["violations"])]


def drc(board: Path) -> dict[str, list[str]]:
    """Return KiCad's faults of a board by kind, a sentence each.

    The kinds are violated design rules, missing tracks, and differences from the schematic.
    """
    report = _report("pcb", "drc", "--severity-all", "--schematic-parity", board)
    names = ("violations", "unconnected_items", "schematic_parity")
    return {name: _sentences(report[name]) for name in names}


def _report(*command: str | Path) -> Any:
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, "report.json")
        _run("kicad-cli", *command[:2], "--format", "json", "-o", file, *command[2:])
        return json.loads(file.read_text("utf-8"))


def _sentences(violations: list[Any]) -> list[str]:
    return [
        f"{v['type']}: " + "; ".join(item["description"] for item in v["items"])
        for v in violations
    ]  # fmt: skip


def faults(folder: Path, name: str) -> list[str]:
    """Return a sentence for each fault that KiCad finds in a board and its schematic."""
    found = [f"ERC {text}" for text in erc(folder / f"{name}.kicad_sch")]
    for kind, texts in drc(folder / f"{name}.kicad_pcb").items():
        found += [f"{kind} {text}" for text in texts]
    return found


# --- files for the board house ------------------------------------------------------------------


def export(folder: Path, name: str, out: Path) -> None:
    """Write the Gerbers, drills, part positions, drawings and 3D model of a board into ``out``."""
    board, sheet = folder / f"{name}.kicad_pcb", folder / f"{name}.kicad_sch"
    gerbers = out / "gerbers"
    shutil.rmtree(out, ignore_errors=True)
    gerbers.mkdir(parents=True)
    pcb = ("kicad-cli", "pcb", "export")
    _run(*pcb, "gerbers", "--layers", LAYERS, "--use-drill-file-origin", "-o", gerbers, board)
    _run(
        *pcb,
        "drill",
        "--drill-origin",
        "plot",
        "--excellon-separate-th",
        "-o",
        f"{gerbers}/",
        board,
    )
    write_zip(FAB / f"{name}-gerbers.zip", [f for f in gerbers.iterdir() if f.suffix != ".gbrjob"])
    _run(*pcb, "step", "--subst-models", "--drill-origin", "-f", "-o", out / f"{name}.step", board)
    _run("kicad-cli", "sch", "export", "pdf", "-o", out / f"{name}-schematic.pdf", sheet)
    _run("kicad-cli", "sch", "export", "svg", "-o", out, sheet)
    for side, layers in (
        ("front", "F.Cu,F.Mask,F.Silkscreen,Edge.Cuts"),
        ("back", "B.Cu,B.Mask,B.Silkscreen,Edge.Cuts"),
    ):
        mirror = ["--mirror"] if side == "back" else []
        _run(
            *pcb,
            "svg",
            "--mode-single",
            "--layers",
            layers,
            "--page-size-mode",
            "2",
            *mirror,
            "--exclude-drawing-sheet",
            "-o",
            out / f"{name}-{side}.svg",
            board,
        )
        _run(
            "kicad-cli",
            "pcb",
            "render",
            "--side",
            "top" if side == "front" else "bottom",
            "-w",
            "1000",
            "-h",
            "900",
            "--background",
            "opaque",
            "--quality",
            "basic",
            "-o",
            out / f"{name}-{side}.png",
            board,
        )
    if name == "amplifier":
        file = out / f"{name}-positions.csv"
        _run(
            *pcb,
            "pos",
            "--format",
            "csv",
            "--units",
            "mm",
            "--side",
            "front",
            "--smd-only",
            "--use-drill-file-origin",
            "-o",
            file,
            board,
        )
        rows = csv.DictReader(file.read_text("utf-8").splitlines())
        kicads = {(r["Ref"], *(round(float(r[c]), 3) for c in ("PosX", "PosY"))) for r in rows}
        _, *ours = positions("jlcpcb")
        if kicads != {
            (r[0], *(round(float(x.removesuffix("mm")), 3) for x in r[1:3])) for r in ours
        }:
            raise RuntimeError(f"{file} has other parts or places than the list for the house")
        write_lists()


# --- faults that the checks must find -----------------------------------------------------------


def _drop_wire(sheet: list[Element]) -> None:
    sheet.remove(next(all_of(sheet, "wire")))


def _other_value(sheet: list[Element]) -> None:
    """Change the value of a resistor in a schematic, for :func:`selftest`."""
    for symbol in all_of(sheet, "symbol"):
        if property_of(symbol, "Reference") == "R13":
            next(p for p in all_of(symbol, "property") if p[1] == "Value")[2] = "8.2k"


def _wide_track(board: list[Element]) -> None:
    one_of(next(all_of(board, "segment")), "width")[1] = 3.0


def _drop_track(board: list[Element]) -> None:
    longest = max(
        (s for s in all_of(board, "segment") if "3v3" not in str(one_of(s, "net"))),
        key=lambda s: sum(
            abs(a - b)
            for a, b in zip(numbers(one_of(s, "start")), numbers(one_of(s, "end")), strict=True)
        ),
    )
    board.remove(longest)


def _swap_pads(board: list[Element]) -> None:
    """Swap the nets of a resistor's pads on a board, for :func:`selftest`."""
    for footprint in all_of(board, "footprint"):
        if property_of(footprint, "Reference") == "R12":
            nets = [one_of(pad, "net") for pad in all_of(footprint, "pad")]
            nets[0][1:], nets[1][1:] = nets[1][1:], nets[0][1:]


#: Fault, the file it is put into, and the check that must report it.
SEEDED: tuple[tuple[str, str, Callable[[list[Element]], None], str], ...] = (
    ("a wire is missing", "kicad_sch", _drop_wire, "ERC"),
    ("a track is too wide", "kicad_pcb", _wide_track, "violations"),
    ("a track is missing", "kicad_pcb", _drop_track, "unconnected_items"),
    ("two pads are swapped", "kicad_pcb", _swap_pads, "schematic_parity"),
    ("a value differs", "kicad_sch", _other_value, "schematic_parity"),
)


def selftest(folder: Path, name: str = "amplifier") -> None:
    """Put one fault after another into copies of a board, to test the checks.

    Raise RuntimeError if a check overlooks its fault.
    """
    for fault, suffix, seed, message in SEEDED:
        with tempfile.TemporaryDirectory() as copy:
            target = Path(copy, name)
            shutil.copytree(folder, target)
            file = target / f"{name}.{suffix}"
            expression = parse(file.read_text("utf-8"))
            seed(expression)
            file.write_text(write(expression), "utf-8")
            found = {message: erc(file)} if message == "ERC" else drc(target / f"{name}.kicad_pcb")
            if not found[message]:
                raise RuntimeError(f"KiCad did not find a seeded fault: {fault}")
            print(f"found as it should be: {fault}")


def main() -> int:
    """Write, check and export both boards."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--selftest", action="store_true", help="only the seeded faults")
    is_selftest = parser.parse_args().selftest
    if found := pin_differences():
        print("\n".join(found), file=sys.stderr)
        return 1
    if missing := missing_packages():
        print(missing, file=sys.stderr)
        return 1
    boards = HERE / "boards"
    if is_selftest:
        selftest(boards / "amplifier")
        return 0
    _run(sys.executable, HERE / "write_schematics.py")
    _run(KICAD_PYTHON, HERE / "write_boards.py")
    for name in BOARDS:
        if found := faults(boards / name, name):
            print("\n".join([f"{name}: {len(found)} faults", *found]), file=sys.stderr)
            return 1
        print(f"{name}: 0 faults in ERC, DRC and the comparison of board and schematic")
        export(boards / name, name, OUT / name)
        for image in IMAGES.glob(f"board-{name}-*.png"):
            shutil.copy(OUT / name / image.name.removeprefix("board-"), image)
    selftest(boards / "amplifier")
    return 0


if __name__ == "__main__":
    sys.exit(main())
