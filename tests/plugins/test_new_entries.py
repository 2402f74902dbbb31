"""A new entry is one file and at most one line. The documented examples run in a copy."""

import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

import pytest

import firstcontact as fc

ROOT = Path(__file__).parents[2]
GUIDE = ROOT / "CONTRIBUTING.md"
HANDS = ROOT / "docs" / "how-to" / "drive-a-hand.md"


class Entry(NamedTuple):
    """New entry of the package: an example, what registers it, and a command that uses it."""

    heading: str
    #: File of the package that holds the example's code, and text before the registry's new line.
    file: str
    anchor: str
    line: str
    command: str
    #: Words that the command must print.
    words: str
    registry: str = "registry.py"
    page: Path = GUIDE


LIVE = "live --device {recording} --model general --speed inf"
ENTRIES = {
    "command": Entry("A command", "cli/verbs/count.py", "", "", "count pinches", "20"),
    "detector": Entry(
        "A detector in ten lines", "contact/_energy.py", '"three_sigma": ',
        '"energy": "firstcontact.contact._energy:EnergyDetector",',
        "train pinches --out energy --detector-type energy --detector-only", "detector energy"
    ),
    "estimator": Entry(
        "An estimator", "models/windows/_loudness.py", '"train_mean": ',
        '"loudness": "firstcontact.models.windows._loudness:Loudness",',
        "train pinches --out loudness --estimator loudness --task regression",
        "loudness (regression)", "../registry.py"
    ),
    "policy": Entry(
        "A policy", "grasp/_halfway.py", '"touch": ',
        '"halfway": "firstcontact.grasp._halfway:Halfway",',
        f"{LIVE} --hand print --policy halfway", "halfway"
    ),
    "hand": Entry(
        "A hand of your own", "grasp/_line.py", '"print": ',
        '"line": "firstcontact.grasp._line:LineHand",',
        f"{LIVE} --hand line --hand-port nowhere", "hand line", page=HANDS
    ),
    "source": Entry(
        "A sensor", "device/_reel.py", "{kind.name: kind",
        '{"reel": "firstcontact.device._reel:REEL"} |',
        "info --device reel:{recording}", "reel:", "opening.py"
    ),
    "output": Entry(
        "An output", "streaming/_table.py", '"text": ',
        '"table": "firstcontact.streaming._table:TABLE",',
        f"{LIVE} --output table", "\n2,0.0", "outputs.py"
    ),
    "exporter": Entry(
        "A file format", "recording/_json.py", '"csv": f"{_HERE}._exporting',
        '"json": "firstcontact.recording._json:EXPORTER",',
        "export pinches --to json --out {folder}/exported.json", "20 pinches written",
        "_formats.py"
    ),
    "importer": Entry(
        "A file format", "recording/_json.py", '"wav": ',
        '"json": "firstcontact.recording._json:IMPORTER",',
        "import {folder}/given.json --out {folder}/imported", "2 pinches", "_formats.py"
    ),
}  # fmt: skip


def example(page: Path, heading: str) -> str:
    """Return the first Python block below a heading, without its checks."""
    text = page.read_text(encoding="utf-8").partition(f"## {heading}\n")[2]
    code = re.search(r"^```python\n(.*?)^```$", text, re.DOTALL | re.MULTILINE)
    assert code is not None, heading
    lines = code[1].partition("\n\n\ncheck_")[0].splitlines()
    return "\n".join(line for line in lines if "firstcontact.testing" not in line) + "\n"


@pytest.fixture(scope="module")
def work(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder with recordings and a model."""
    folder = tmp_path_factory.mktemp("entries")
    fc.simulate(folder / "pinches", pinches_per_block=4, pinches_per_object=0)
    fc.adapt().save(folder / "general")
    signals = [[[0.0, 0.0]] * 3000] * 2
    given = {"piezo": signals, "shore_a": [10.0, 20.0], "sample_rate_hz": 4936.0, "piezo_unit": "V"}
    (folder / "given.json").write_text(str(given).replace("'", '"'), encoding="utf-8")
    return folder


@pytest.fixture
def package(tmp_path: Path) -> Path:
    """Copy of the package, with what is compiled."""
    return Path(shutil.copytree(Path(fc.__file__).parent, tmp_path / "src" / "firstcontact"))


def run(package: Path, command: str, work: Path) -> subprocess.CompletedProcess[str]:
    """Run a command of a copy of the package."""
    recording = next((work / "pinches").glob("*.mcap"))
    words = command.format(recording=recording, folder=package.parents[1]).split()
    process = subprocess.run(
        [sys.executable, "-m", "firstcontact.cli.main", *words],
        cwd=work,
        env={**os.environ, "PYTHONPATH": str(package.parent)},
        capture_output=True,
        text=True,
    )
    assert process.returncode == 0, process.stderr
    return process


@pytest.mark.parametrize("kind", ENTRIES)
def test_a_new_entry_is_one_file_and_at_most_one_line(
    kind: str, work: Path, package: Path, tmp_path: Path
) -> None:
    entry = ENTRIES[kind]
    file = package / entry.file
    assert not file.exists()
    file.write_text(example(entry.page, entry.heading), encoding="utf-8")
    if entry.anchor:
        registry = file.parent / entry.registry
        text = registry.read_text(encoding="utf-8")
        assert text.count(entry.anchor) == 1
        registry.write_text(text.replace(entry.anchor, f"{entry.line}\n        {entry.anchor}"))
    shutil.copy(work / "given.json", tmp_path)
    process = run(package, entry.command, work)
    assert entry.words in process.stdout + process.stderr


def test_a_field_on_the_page_takes_three_files(work: Path, package: Path) -> None:
    text = GUIDE.read_text(encoding="utf-8").partition("## A field on the page\n")[2]
    recipe = text.partition("\n## ")[0].replace("\\|", "|")
    steps = re.findall(r"^\| `(.+?)` \| `(.+)` \| `(.+)` \|$", recipe, re.MULTILINE)
    assert len(steps) == 3
    for name, original, line in steps:
        file = package / "streaming" / name
        lines = file.read_text(encoding="utf-8").splitlines()
        assert lines.count(original) == 1, (name, original)
        lines.insert(lines.index(original) + 1, line)
        file.write_text("\n".join(lines) + "\n", encoding="utf-8")
    process = run(package, "live --device {recording} --model general --speed inf --json", work)
    pinches = [p for p in map(json.loads, process.stdout.splitlines()) if p["type"] == "pinch"]
    assert pinches
    assert [p["samples"] for p in pinches] == [p["end"] - p["start"] for p in pinches]
