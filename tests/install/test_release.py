"""A release has one version, and names the paper and its installation where people look."""

import re
import tomllib
from pathlib import Path

import yaml

import firstcontact

ROOT = Path(__file__).parents[2]
VERSION = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]["version"]


def test_the_version_is_that_of_pyproject_and_of_the_newest_changes() -> None:
    assert firstcontact.__version__ == VERSION, "make install"
    changes = (ROOT / "CHANGELOG.md").read_text("utf-8")
    newest = re.search(r"^## (\d+\.\d+\.\d+), (not yet released|\d{4}-\d\d-\d\d)$", changes, re.M)
    assert newest[1] == VERSION


def test_sources_do_not_repeat_the_version() -> None:
    written = "firmware/core/fc_layout.h"  # tests/firmware/test_sketch.py compares its version
    files = [p for room in ("src", "firmware") for p in (ROOT / room).rglob("*.*")]
    files = [p for p in files if p.suffix in {".py", ".pyi", ".c", ".h", ".ino", ".js", ".html"}]
    files = [p for p in files if p != ROOT / written]
    assert [p for p in files if f'"{VERSION}' in p.read_text("utf-8")] == []


def test_the_citation_names_the_paper_that_the_readme_names() -> None:
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text("utf-8"))
    assert {"cff-version", "message", "title", "authors"} <= citation.keys()
    (paper,) = citation["references"]
    readme = " ".join((ROOT / "README.md").read_text("utf-8").split())
    assert paper["title"] in readme
    assert all(author["family-names"] in readme for author in paper["authors"])


def test_issue_templates_ask_for_the_installation() -> None:
    templates = [*(ROOT / ".github/ISSUE_TEMPLATE").glob("*.md")]
    assert templates
    for template in templates:
        head = template.read_text("utf-8").split("---\n")[1]
        assert {"name", "about"} <= yaml.safe_load(head).keys()
        assert "`firstcontact info`" in template.read_text("utf-8")
