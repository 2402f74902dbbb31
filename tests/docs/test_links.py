"""Links have a target, and no page names a path of one machine."""

import inspect
import re
import subprocess
import sys
from enum import Enum
from pathlib import Path

import pytest
from pages import PAGES, ROOT, name

import firstcontact as fc

LINK = re.compile(r"!?\[[^\]]*\]\((?P<target>[^)\s]+)\)")
#: What a path of somebody's machine looks like. `../shared` is the documented place for data.
FOREIGN = re.compile(r"(?<![\w.<])/(?:work|home|root|Users|tmp|mnt|opt|workspace)\b")


def anchors(text: str) -> set[str]:
    """Return the anchors of a page's headings."""
    heads = re.findall(r"^#+ +(.*)$", text, re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", h).strip().lower().replace(" ", "-") for h in heads}


@pytest.mark.parametrize("page", PAGES, ids=name)
def test_links_resolve(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    for match in LINK.finditer(text):
        path, _, anchor = match["target"].partition("#")
        if re.match(r"[a-z]+:", path):
            continue
        target = (page.parent / path).resolve() if path else page
        assert target.exists(), f"{name(page)}: {match['target']}"
        assert ROOT in [target, *target.parents], (
            f"{name(page)}: {match['target']} leaves the project"
        )
        if anchor:
            assert anchor in anchors(target.read_text(encoding="utf-8")), match["target"]


def tracked() -> list[Path]:
    """Return the text files of the project, including new ones that are not committed."""
    process = subprocess.run(
        ["git", "ls-files", "--cached", "--others", "--exclude-standard"],
        cwd=ROOT,
        capture_output=True,
        text=True,
    )
    if process.returncode:  # a source archive
        return PAGES
    paths = [ROOT / line for line in process.stdout.splitlines()]
    kinds = {".md", ".py", ".toml", ".yml", ".txt", ".json", ".html", ""}
    return [p for p in paths if p.is_file() and p.suffix in kinds]


def test_no_file_names_a_path_of_one_machine() -> None:
    collected = []
    for path in tracked():
        if path.resolve() == Path(__file__).resolve():
            continue
        for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
            if FOREIGN.search(line):
                collected.append(f"{name(path)}:{number}: {line.strip()[:80]}")
    assert collected == []


def test_the_site_builds_and_asks_nothing_of_a_network(tmp_path: Path) -> None:
    process = subprocess.run(
        [sys.executable, "-m", "mkdocs", "build", "--strict", "--site-dir", tmp_path],
        cwd=ROOT,
        capture_output=True,
        text=True,
    )
    assert process.returncode == 0, process.stdout + process.stderr
    page_text = (tmp_path / "reference/python.html").read_text(encoding="utf-8")
    for kind in (getattr(fc, word) for word in fc.__all__):
        own = vars(kind) if inspect.isclass(kind) and not issubclass(kind, Enum) else ()
        for member in (m for m in own if m[0] != "_" and inspect.isfunction(own[m])):
            assert f'id="firstcontact.{kind.__name__}.{member}"' in page_text, member
    wanted = re.compile(r"""<(?:script|img|link)\b[^>]*(?:src|href)=["'](?:https?:)?//[^"']*""")
    for page in tmp_path.rglob("*.html"):
        outside = [
            m for m in wanted.findall(page.read_text(encoding="utf-8")) if "canonical" not in m
        ]
        assert outside == [], page.name
    for sheet in tmp_path.rglob("*.css"):
        assert not re.search(r"url\(['\"]?(?:https?:)?//", sheet.read_text(encoding="utf-8")), sheet
