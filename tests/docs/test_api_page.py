"""The pages of the public interface agree with the package."""

from __future__ import annotations

import json
from pathlib import Path

from pages import ROOT

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
