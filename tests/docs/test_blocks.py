"""Every block of Python in the pages runs, on its own, warnings being errors."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest
from pages import PAGES, ROOT

BLOCK = re.compile(r"^```python\n(.*?)^```$", re.DOTALL | re.MULTILINE)
BLOCKS = [
    (page, number, code)
    for page in PAGES
    for number, code in enumerate(BLOCK.findall(page.read_text(encoding="utf-8")))
]


def test_there_are_some() -> None:
    assert any(page.name == "CONTRIBUTING.md" for page, *_ in BLOCKS)


@pytest.mark.parametrize(
    ("page", "number", "code"),
    BLOCKS,
    ids=[f"{page.relative_to(ROOT)}-{number}" for page, number, _ in BLOCKS],
)
def test_it_runs(page: Path, number: int, code: str, tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", code], cwd=tmp_path, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
