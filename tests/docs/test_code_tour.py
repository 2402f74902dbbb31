"""The code tour names what exists, the rooms are listed, and the glossary stays short."""

import re
import tomllib

import pytest
from pages import ROOT

TOUR = (ROOT / "docs" / "explanation" / "code-tour.md").read_text(encoding="utf-8")
GLOSSARY = (ROOT / "docs" / "reference" / "glossary.md").read_text(encoding="utf-8")
ROWS = re.findall(r"^\| ([^|]+\?) \| (.+) \| (`.+`) \| (.+) \|$", TOUR, re.MULTILINE)


def source(path: str) -> str:
    folder = ROOT if path.startswith("firmware/") else ROOT / "src" / "firstcontact"
    return (folder / path).read_text(encoding="utf-8")


def test_each_row_of_the_tour_is_a_question() -> None:
    assert len(ROWS) >= 15
    assert len(ROWS) == sum(".py:" in line or ".c:" in line for line in TOUR.splitlines())


@pytest.mark.parametrize(("question", "places", "word"), [(q, p, w) for q, _, p, w in ROWS])
def test_places_of_an_answer_exist_and_its_word_leads_there(question, places, word) -> None:
    named = re.findall(r"`([^`:]+):(\w+)`", places)
    assert len(named) == places.count(", ") + 1
    texts = {path: source(path) for path, _ in named}
    assert len(texts) <= 3
    for path, name in named:
        is_python = path.endswith(".py")
        defined = rf"\b(?:def|class) {name}\b|\b{name}\b *[:=]" if is_python else rf"\b{name}\b"
        assert re.search(defined, texts[path]), f"{path}:{name}"
    assert word.lower() in " ".join(texts[named[0][0]].lower().split())


def test_the_page_on_architecture_lists_all_rooms() -> None:
    page = (ROOT / "docs" / "explanation" / "architecture.md").read_text(encoding="utf-8")
    listed = page.partition("## The rooms")[2].partition("### ")[0]
    contracts = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["importlinter"]
    layers = " ".join(contracts["contracts"][0]["layers"]).removeprefix("__main__ ")
    rooms = [cells.split(" | ")[0] for cells in re.findall(r"^\| (`.+) \|$", listed, re.MULTILINE)]
    assert sorted(re.findall(r"\w+", " ".join(rooms))) == sorted(re.findall(r"\w+", layers))


def test_the_glossary_is_in_order_and_each_entry_is_short() -> None:
    rows = re.findall(r"^\| (.+?) \| (.+) \|$", GLOSSARY, re.MULTILINE)[1:]
    terms = [term for term, _ in rows]
    assert terms == sorted(terms, key=str.lower)
    assert len(terms) >= 30
    assert max(len(meaning) for _, meaning in rows) <= 160
