"""The files and names of the code tour exist, and the glossary stays short."""

from __future__ import annotations

import re

import pytest
from pages import ROOT

TOUR = (ROOT / "docs" / "explanation" / "code-tour.md").read_text(encoding="utf-8")
GLOSSARY = (ROOT / "docs" / "reference" / "glossary.md").read_text(encoding="utf-8")
SECTIONS = re.split(r"^## ", TOUR, flags=re.MULTILINE)[1:]
ROW = re.compile(r"^\| `([^`]+)` \| (.+) \|$", re.MULTILINE)


def test_there_are_five_questions() -> None:
    assert len(SECTIONS) == 5
    assert all(section.partition("\n")[0].endswith("?") for section in SECTIONS)


@pytest.mark.parametrize("section", SECTIONS, ids=[s.partition("\n")[0] for s in SECTIONS])
def test_an_answer_names_at_most_three_files_and_what_is_in_them(section: str) -> None:
    rows = ROW.findall(section)
    assert 1 <= len(rows) <= 3
    for file, names in rows:
        text = (ROOT / file).read_text(encoding="utf-8")
        for name in re.findall(r"`([^`]+)`", names):
            defined = rf"\b(?:def|class) {name}\b|\b{name}\b *[:=]"
            assert re.search(defined if file.endswith(".py") else re.escape(name), text), name


def test_the_glossary_is_in_order_and_each_entry_is_short() -> None:
    rows = re.findall(r"^\| (.+?) \| (.+) \|$", GLOSSARY, re.MULTILINE)[1:]
    terms = [term for term, _ in rows]
    assert terms == sorted(terms, key=str.lower)
    assert len(terms) >= 30
    assert max(len(meaning) for _, meaning in rows) <= 160
