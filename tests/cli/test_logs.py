"""The log is silent, except with ``--verbose`` or after an error."""

import logging
import re

import pytest
from tqdm import tqdm

from firstcontact.cli.logs import logged

LOG = logging.getLogger("firstcontact.somewhere")


@pytest.mark.parametrize(
    ("verbose", "displayed"), [(False, ["careful"]), (True, ["begun", "careful"])]
)
def test_only_warnings_are_printed_unless_verbose(
    verbose: bool, displayed: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    with logged(verbose):
        LOG.info("begun\x1b[31m")
        LOG.warning("careful")
    LOG.info("nobody listens")
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == len(displayed)
    for line, word in zip(lines, displayed, strict=True):
        assert word in line
        assert "firstcontact.somewhere" in line
        assert "\x1b" not in line


def test_a_warning_beside_a_progress_bar_gets_a_separate_line(
    capsys: pytest.CaptureFixture[str],
) -> None:
    with logged(False), tqdm(total=3, desc="pinches") as bar:
        LOG.warning("careful")
        bar.update(3)
    written = re.split(r"[\r\n]+", capsys.readouterr().err)
    (line,) = (part for part in written if "careful" in part)
    assert re.fullmatch(r"\S+Z firstcontact.somewhere: careful", line)
    assert any("3/3" in part for part in written)
