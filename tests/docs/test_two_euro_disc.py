"""Commands of the page about the disc run, with the twin's taps played to PortAudio."""

import json
import re
import runpy
import shlex
import threading
import webbrowser
from pathlib import Path

import numpy as np
import pytest
from pages import ROOT, fences
from websockets.sync.client import connect

from firstcontact.cli.main import main
from sound import local_sound

pytestmark = pytest.mark.usefixtures("small_searches")
PAGE = ROOT / "docs/tutorial/two-euro-disc.md"
#: Hardness of what is tapped; at first nothing is.
SHORES = {"putty": 10.0, "eraser": 29.0, "heel": 60.0}


def commands() -> list[list[str]]:
    """Return the words of each command."""
    text = "".join(f.body for f in fences(PAGE) if f.mark == "disc")
    return [w for line in text.replace("\\\n", " ").splitlines() if (w := shlex.split(line))]


class Newcomer(threading.Thread):
    """Reader who follows the page: accepts touches, rejects rebounds, and finishes."""

    #: What comes so soon after a touch is its end, s; the next tap is 0.65 s later.
    ENDS = 0.2

    def __init__(self, url: str) -> None:
        super().__init__(daemon=True)
        self._url = url
        self.finished: list[str] = []

    def run(self) -> None:
        with connect(self._url.replace("http:", "ws:") + "socket") as page:
            hello = json.loads(page.recv())
            touch: dict[str, int] | None = None
            for mark in hello["marks"]:
                reach = self.ENDS * hello["recordings"][mark["recording"]]["rate"]
                same = touch and all(touch[of] == mark[of] for of in ("recording", "stretch"))
                ends = same and touch and mark["sample"] - touch["sample"] < reach
                touch = touch if ends else mark
                page.send(json.dumps({"do": "reject" if ends else "accept", **numbered(mark)}))
                assert "mark" in json.loads(page.recv())
            page.send('{"ask": "finish"}')
            self.finished = json.loads(page.recv())["finished"]


def numbered(mark: dict[str, int]) -> dict[str, int]:
    return {"number": mark["number"]}


@pytest.mark.slow  # test_commands.py parses the commands, tests/cli/test_audio.py has inputs
def test_every_command_runs_and_hard_things_sound_hard(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    tape = runpy.run_path(str(ROOT / "examples/tap_tape.py"))["tape"]
    quiet = (40 * np.random.default_rng(0).standard_normal(48_000 * 20)).astype(np.int16)
    (tmp_path / "work").mkdir()
    monkeypatch.chdir(tmp_path / "work")
    assert len(commands()) == 11
    newcomers: list[Newcomer] = []
    monkeypatch.setattr(webbrowser, "open", lambda url: _begun(url, newcomers))
    for name, *words in commands():
        assert name == "firstcontact"
        samples = quiet
        if "--object" in words:  # more taps than are wanted: at the tape's end the input is gone
            samples = tape(SHORES[words[words.index("--object") + 1]], 13, 1)
        elif words[0] == "live":
            samples = tape(60.0, 7, 2)
        with local_sound(tmp_path, samples):
            ended = main(words)
        captured = capsys.readouterr()
        assert ended == 0, f"{words}\n{captured.out}\n{captured.err}"
        # A disc alone has no hand and no motor, is no microphone, and its unit is not the volt.
        assert not re.findall(r"\b(?:hand|motor|microphone|mV)\b", captured.out + captured.err), (
            words
        )
        if words[:2] == ["inspect", "taps/session-1.mcap"]:
            assert captured.out.count("not confirmed") == 10
        if words[:2] == ["inspect", "labelled/session-1.mcap"]:
            assert captured.out.count("contact accepted by") == 10
            assert "not confirmed" not in captured.out
    (newcomer,) = newcomers
    newcomer.join(30)
    assert len(newcomer.finished) == 3
    assert all(": 10 pinches" in line for line in newcomer.finished)
    values = [
        float(v) for v in re.findall(r"pinch \d+: sensor first, ([\d.]+) Shore A", captured.out)
    ]
    assert len(values) == 4
    assert 45 < np.median(values) < 75


def _begun(url: str, newcomers: list[Newcomer]) -> None:
    newcomers.append(Newcomer(url))
    newcomers[-1].start()
