"""The page of the command line agrees with the commands' help."""

from pathlib import Path

from pages import ROOT

import forked


def test_the_page_is_what_help_prints(tmp_path: Path) -> None:
    page_text = (ROOT / "docs/reference/cli.md").read_text(encoding="utf-8")
    (tmp_path / "now.md").write_text(page_text, encoding="utf-8")
    code = (
        "import help_of_docs, pathlib; now = pathlib.Path('now.md'); "
        "now.write_text(help_of_docs.page(now.read_text()))"
    )
    (tmp_path / "help_of_docs.py").write_text(
        (ROOT / "docs/write_cli.py").read_text(encoding="utf-8")
    )
    assert forked.run("code", code, cwd=tmp_path).returncode == 0
    now = (tmp_path / "now.md").read_text(encoding="utf-8")
    assert page_text == now, "python docs/write_cli.py"
