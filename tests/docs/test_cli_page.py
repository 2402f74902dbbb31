"""The page of the command line agrees with the commands' help."""

from __future__ import annotations

from pathlib import Path

from pages import ROOT

import forked


def test_the_page_is_what_help_prints(tmp_path: Path) -> None:
    code = "import help_of_docs, pathlib; pathlib.Path('now.md').write_text(help_of_docs.page())"
    (tmp_path / "help_of_docs.py").write_text(
        (ROOT / "docs/write_cli.py").read_text(encoding="utf-8")
    )
    assert forked.run("code", code, cwd=tmp_path).returncode == 0
    now = (tmp_path / "now.md").read_text(encoding="utf-8")
    page_text = (ROOT / "docs/reference/cli.md").read_text(encoding="utf-8")
    assert page_text == now, "python docs/write_cli.py"
