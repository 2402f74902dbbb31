"""Every example runs without a warning."""

from __future__ import annotations

from pathlib import Path

import pytest
from pages import ROOT

import forked

EXAMPLES = sorted(ROOT.glob("examples/*.py"))
#: It needs ROS 2; tests/test_front_door.py runs it with a stand-in for rclpy.
ELSEWHERE = ("ros_node",)
#: It runs a benchmark, as tests/lab/verbs/test_benchmark.py does.
LONG = ("own_regressor",)


#: Runs an example with the smallest sets of its comparison.
SMALLEST = """
import runpy, sys
from dataclasses import replace
from pathlib import Path
from firstcontact_lab.study import benchmark
from firstcontact_lab.study._rig_sets import Sizes
sizes = Sizes(blocks=6, held_out=3, objects=5, other_blocks=3, kinds=6)
benchmark.QUICK = replace(benchmark.QUICK, sizes=sizes)
sys.path.insert(0, str(Path(sys.argv[1]).parent))
runpy.run_path(sys.argv[1], run_name="__main__")
"""


@pytest.mark.parametrize(
    "example",
    [
        pytest.param(e, id=e.stem, marks=[pytest.mark.slow] if e.stem in LONG else [])
        for e in EXAMPLES
        if e.stem not in ELSEWHERE
    ],
)
def test_example_runs(example: Path, tmp_path: Path) -> None:
    is_large = "benchmark import QUICK" in example.read_text(encoding="utf-8")
    words = ("code", SMALLEST, example) if is_large else ("script", example)
    process = forked.run(*words, cwd=tmp_path, strict=True)
    assert process.returncode == 0, process.stderr
    assert process.stdout


@pytest.mark.parametrize("example", EXAMPLES, ids=lambda p: p.stem)
def test_example_is_named_in_a_page(example: Path) -> None:
    pages = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *ROOT.glob("docs/**/*.md")]
    assert any(f"examples/{example.name}" in p.read_text(encoding="utf-8") for p in pages)
