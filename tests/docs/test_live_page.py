"""The page of live output lists the fields of the program's records."""

from __future__ import annotations

from pathlib import Path

from pages import ROOT

import forked


def test_the_tables_are_written_from_the_records(tmp_path: Path) -> None:
    code = "import live_of_docs, pathlib; pathlib.Path('now.md').write_text(live_of_docs.page())"
    script = (ROOT / "docs/write_live.py").read_text(encoding="utf-8")
    script = script.replace("Path(__file__).parent", f"Path({str(ROOT / 'docs')!r})")
    (tmp_path / "live_of_docs.py").write_text(script, encoding="utf-8")
    assert forked.run("code", code, cwd=tmp_path).returncode == 0
    now = (tmp_path / "now.md").read_text(encoding="utf-8")
    page_text = (ROOT / "docs/reference/live-output.md").read_text(encoding="utf-8")
    assert page_text == now, "python docs/write_live.py"
    assert "### estimate\n" in now
