"""The pages of the public interface agree with the package."""

from __future__ import annotations

import inspect
import json
import re
from enum import Enum
from pathlib import Path

from pages import ROOT

import firstcontact as fc
import forked


def test_the_pages_are_what_docstrings_say(tmp_path: Path) -> None:
    code = (
        "import api_of_docs, json, pathlib; "
        "pathlib.Path('now.json').write_text(json.dumps(api_of_docs.pages()))"
    )
    script = (ROOT / "docs/write_api.py").read_text(encoding="utf-8")
    (tmp_path / "api_of_docs.py").write_text(script, encoding="utf-8")
    assert forked.run("code", code, cwd=tmp_path).returncode == 0
    now = json.loads((tmp_path / "now.json").read_text(encoding="utf-8"))
    for file, text in now.items():
        page_text = (ROOT / "docs/reference" / file).read_text(encoding="utf-8")
        assert page_text == text, "python docs/write_api.py"
        assert "|  |" not in text, "a name without a docstring"


def test_the_page_for_users_lists_parameters_and_members() -> None:
    page = (ROOT / "docs/reference/python.md").read_text(encoding="utf-8")
    sections = dict(re.findall(r"^### (\w+)\n(.*?)(?=^##|\Z)", page, re.MULTILINE | re.DOTALL))
    classes = [name for name in fc.__all__ if inspect.isclass(getattr(fc, name))]
    classes = [name for name in classes if not issubclass(getattr(fc, name), Enum | Exception)]
    assert {"Dataset", "Model", "Pinch"} <= set(classes)
    for name in classes:
        kind = getattr(fc, name)
        expected = {member for member in dir(kind) if inspect.isfunction(getattr(kind, member))}
        if not inspect.isabstract(kind):
            expected |= set(inspect.signature(kind).parameters)
        listed = set(re.findall(r"`(\w+)[`(]", sections[name]))
        assert {word for word in expected if not word.startswith("_")} <= listed, name
