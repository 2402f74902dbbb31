"""A package adds a part to the study with one file and one registered line.

The part then appears in all places where the built-in parts do.
"""

import importlib
import json
import re
import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest
import write_tables

from firstcontact.core import Dataset
from firstcontact.jobs import Serial
from firstcontact_lab.report.findings import Findings
from firstcontact_lab.report.page import sections
from firstcontact_lab.report.results import FIELDS
from firstcontact_lab.report.run import run_jobs
from firstcontact_lab.study.page import read_study
from firstcontact_lab.study.part import StudySettings
from firstcontact_lab.study.parts import PARTS
from firstcontact_lab.study.run import plan
from partial import results, study_state

ROOT = Path(__file__).parents[3]


def example() -> str:
    """Return the part that CONTRIBUTING shows."""
    text = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    section = text.split("## A study part")[1]
    match = re.search(r"```python\n(.*?)```", section, re.DOTALL)
    return match[1]


@pytest.fixture
def loudness(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Install a package with the part that CONTRIBUTING shows."""
    site = tmp_path / "site"
    info = site / "loudness-1.0.dist-info"
    info.mkdir(parents=True)
    (site / "loudness.py").write_text(example(), encoding="utf-8")
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: loudness\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text("[firstcontact_lab.parts]\nloudness = loudness:PART\n")
    monkeypatch.syspath_prepend(site)
    importlib.invalidate_caches()
    PARTS.reload()
    yield
    PARTS.reload()
    sys.modules.pop("loudness", None)
    FIELDS.pop("loudness", None)


def test_a_new_part_is_in_report_results_and_docs_table(
    loudness: None, shore: Dataset, tmp_path: Path
) -> None:
    settings = replace(StudySettings(), brief=True, workers=1)
    jobs = plan([("recordings", lambda: shore)], settings, Serial())
    jobs = [job for job in jobs if job.part in ("data", "loudness")]
    titles = [job.title for job in jobs]
    assert titles == ["data", "loudness"]
    run_jobs(jobs, study_state(settings), tmp_path)

    found = json.loads((tmp_path / "results.json").read_text())["loudness"]
    assert found["mean"] > 0
    assert found["n"] > 0

    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    section = page.split('<section id="loudness">')[1].split("</section>")[0]
    assert "data:image/svg+xml" in section
    number = f"{found['mean']:.3f}"
    assert number in section
    claims = page.split('<section id="claims">')[1].split("</section>")[0]
    assert number in claims
    assert "not published" in claims

    docs = tmp_path / "docs"
    docs.mkdir()
    (docs / "study.json").write_bytes((tmp_path / "results.json").read_bytes())
    made = write_tables.tables(docs)
    assert any(number in line and "RMS" in line for line in made["study"].splitlines())
    assert number in made["loudness"]


def test_a_part_without_results_is_nowhere(loudness: None) -> None:
    empty = Findings("recordings", results(data={}))
    assert [section.anchor for section in sections([empty], PARTS)] == ["data"]
    assert write_tables.part_tables("loudness", {"here": empty.results}) == ""


def test_results_of_a_part_that_is_not_installed_are_refused(tmp_path: Path) -> None:
    tree = json.loads((ROOT / "docs/results/real.json").read_text(encoding="utf-8"))
    (tmp_path / "results.json").write_text(json.dumps({**tree, "loudness": {"mean": 1.0, "n": 2}}))
    with pytest.raises(ValueError, match=r"results\.json"):
        read_study(tmp_path / "results.json")
