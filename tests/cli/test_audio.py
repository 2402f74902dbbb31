"""Commands that read a sound input, for which PortAudio plays a recorded tape."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from firstcontact.cli.main import main
from sound import local_sound


@pytest.fixture
def quiet() -> np.ndarray:
    return np.random.default_rng(0).normal(0, 30, 48_000).astype(np.int16)


def test_ports_lists_the_inputs(
    tmp_path: Path, quiet: np.ndarray, capsys: pytest.CaptureFixture[str]
) -> None:
    with local_sound(tmp_path, quiet):
        assert main(["ports"]) == 0
    assert "audio:disc       sound input, 1 channel, 48000 Hz" in capsys.readouterr().out


def test_info_says_what_it_is_and_what_its_filter_costs(
    tmp_path: Path, quiet: np.ndarray, capsys: pytest.CaptureFixture[str]
) -> None:
    with local_sound(tmp_path, quiet, loop=1):
        assert main(["info", "--device", "audio:disc"]) == 0
    output = capsys.readouterr().out
    assert "its own filter delays samples by 0.36 ms" in output
    assert "sound input disc" in output


def test_live_counts_the_filter_in_its_ledger(
    tmp_path: Path, quiet: np.ndarray, capsys: pytest.CaptureFixture[str]
) -> None:
    with local_sound(tmp_path, quiet, loop=1):
        assert main(["live", "--device", "audio:disc", "--seconds", "0.3"]) == 0
    errors = capsys.readouterr().err
    assert "0.360 ms of each wait are the source's own filter" in errors
