"""Every example runs without a warning."""

from __future__ import annotations

from pathlib import Path

import pytest
from pages import ROOT

import forked

EXAMPLES = sorted(ROOT.glob("examples/*.py"))
#: It needs ROS 2; tests/test_front_door.py runs it with a stand-in for rclpy.
ELSEWHERE = ("ros_node",)


@pytest.mark.parametrize(
    "example",
    [pytest.param(e, id=e.stem) for e in EXAMPLES if e.stem not in ELSEWHERE],
)
def test_example_runs(example: Path, tmp_path: Path) -> None:
    process = forked.run("script", example, cwd=tmp_path, strict=True)
    assert process.returncode == 0, process.stderr
    assert process.stdout


@pytest.mark.parametrize("example", EXAMPLES, ids=lambda p: p.stem)
def test_example_is_named_in_a_page(example: Path) -> None:
    pages = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *ROOT.glob("docs/**/*.md")]
    assert any(f"examples/{example.name}" in p.read_text(encoding="utf-8") for p in pages)
