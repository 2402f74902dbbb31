"""The page of the public interface agrees with the package."""

from __future__ import annotations

from pathlib import Path

from pages import ROOT

import forked


def test_the_page_is_what_docstrings_say(tmp_path: Path) -> None:
    code = "import api_of_docs, pathlib; pathlib.Path('now.md').write_text(api_of_docs.page())"
    script = (ROOT / "docs/write_api.py").read_text(encoding="utf-8")
    (tmp_path / "api_of_docs.py").write_text(script, encoding="utf-8")
    assert forked.run("code", code, cwd=tmp_path).returncode == 0
    now = (tmp_path / "now.md").read_text(encoding="utf-8")
    page_text = (ROOT / "docs/reference/python.md").read_text(encoding="utf-8")
    assert page_text == now, "python docs/write_api.py"
    assert "|  |" not in now, "a name without a docstring"
