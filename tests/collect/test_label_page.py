"""The labelling page in a real browser, by its keys."""

from __future__ import annotations

import json
import re
import resource
import signal
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest
from taps import PIEZO, taps, write_taps
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import connect

from firstcontact.collect import Labeller, LabelServer, Session, open_recordings
from firstcontact.recording import load_dataset
from page_browser import UPGRADE, ask, browsing, needs_browser, text, until


class Labelling:
    """A page that is served in a thread until it is finished."""

    def __init__(self, folder: Path, n: int, every: float = 0.25) -> None:
        path = write_taps(folder / "taps.mcap", n, every)
        self.out = folder / "out"
        by = Labeller("Ada", "2026-01-02", "a test")
        recordings = open_recordings([path])
        #: The signal, V.
        self.data = recordings[0].stretches[0].data[:, 0] * PIEZO.scale
        self.session = Session(recordings, self.out, by)
        self.server = LabelServer(self.session, 0)
        ready = threading.Event()
        self.thread = threading.Thread(target=self.server.run, args=(ready.set,), daemon=True)
        self.thread.start()
        assert ready.wait(30)

    def close(self) -> None:
        if self.thread.is_alive():
            self.server.stop()
            self.thread.join(30)
        self.session.close()

    @property
    def port(self) -> int:
        return int(self.server.url.rstrip("/").rpartition(":")[2])


@pytest.fixture
def labelling(tmp_path: Path) -> Iterator[Labelling]:
    its = Labelling(tmp_path, 10)
    yield its
    its.close()


@pytest.fixture(scope="module")
def chromium(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    with browsing(tmp_path_factory.mktemp("profile")) as driver:
        yield driver


def press(driver: Any, *keys: str) -> None:
    from selenium.webdriver.common.action_chains import ActionChains

    ActionChains(driver).send_keys(*keys).perform()


def counts(driver: Any, said: str) -> None:
    until(driver, lambda d: said in text(d, "counts"))


@needs_browser
def test_a_recording_is_labelled_by_keys_alone(labelling: Labelling, chromium: Any) -> None:
    from selenium.webdriver.common.keys import Keys

    chromium.get(labelling.server.url)
    counts(chromium, "10 open")
    press(chromium, "o")
    press(chromium, "eraser", Keys.TAB, "40", Keys.ENTER)
    until(chromium, lambda d: "eraser, 40 Shore A" in text(d, "what"))
    press(chromium, " ", " ", "x", " ")
    counts(chromium, "3 accepted, 1 rejected, 6 open")
    press(chromium, "u")
    counts(chromium, "2 accepted, 1 rejected, 7 open")
    press(chromium, ">", ".")
    until(chromium, lambda d: "moved by 1.13 ms" in text(d, "what"))
    press(chromium, Keys.TAB, "+", "-", "-")
    # Nothing is added where the signal that is pointed at has not come yet.
    until(chromium, lambda d: d.execute_script("return drawn()"))
    press(chromium, "n")
    counts(chromium, "4 accepted")
    assert len(labelling.session.marks) == 11
    chromium.execute_script("window.confirm = () => true")
    press(chromium, "f")
    until(chromium, lambda d: "Written" in text(d, "said"))
    labelling.thread.join(30)
    assert not labelling.thread.is_alive()
    dataset = load_dataset(labelling.out / "taps.mcap")
    assert len(dataset) == 4
    assert set(dataset.objects.tolist()) == {"eraser"}
    firsts = [p.first.sample for p in dataset.pinches if p.first]
    assert firsts[:2] == pytest.approx(taps(10)[:2], abs=2)
    assert not [
        e
        for e in chromium.get_log("browser")
        if e["level"] == "SEVERE" and "favicon" not in e["message"]
    ]


@needs_browser
def test_one_key_an_onset_is_enough_and_every_key_is_answered(
    tmp_path: Path, chromium: Any
) -> None:
    labelling = Labelling(tmp_path, 60)
    chromium.get(labelling.server.url)
    counts(chromium, "60 open")
    press(chromium, *(" " * 60))
    counts(chromium, "60 accepted, 0 rejected, 0 open")
    assert chromium.execute_script("return state.keys") == 60
    until(chromium, lambda d: len(labelling.session.marks.done) == 60)
    # Opened anew, everything is there.
    chromium.refresh()
    counts(chromium, "60 accepted")
    chromium.execute_script("window.confirm = () => true")
    press(chromium, "f")
    until(chromium, lambda d: "Written" in text(d, "said"))
    labelling.thread.join(30)
    assert len(load_dataset(labelling.out / "taps.mcap")) == 60
    labelling.close()


@needs_browser
def test_a_key_after_undo_is_for_the_reopened_onset(labelling: Labelling, chromium: Any) -> None:
    chromium.get(labelling.server.url)
    counts(chromium, "10 open")
    press(chromium, " ", " ", "u", "x", " ")
    counts(chromium, "2 accepted, 1 rejected, 7 open")
    done = [m.status.value for m in labelling.session.marks.ordered()[:4]]
    assert done == ["accepted", "rejected", "accepted", "found"]
    press(chromium, "u", "u")
    until(chromium, lambda d: "onset 2 of 10" in text(d, "place"))
    assert "open" in text(chromium, "what")


@needs_browser
def test_open_onsets_are_counted_where_the_list_and_the_labelling_end(
    labelling: Labelling, chromium: Any
) -> None:
    from selenium.webdriver.common.keys import Keys

    chromium.get(labelling.server.url)
    counts(chromium, "10 open")
    press(chromium, " ", Keys.END, " ")
    until(chromium, lambda d: "8 before it are still open" in text(d, "said"))
    press(chromium, Keys.TAB)
    until(chromium, lambda d: "onset 2 of 10" in text(d, "place"))
    chromium.execute_script("window.confirm = (said) => { window.asked = said; return false; }")
    press(chromium, "f")
    until(chromium, lambda d: d.execute_script("return window.asked"))
    assert "8 of 10 onsets are still open" in chromium.execute_script("return window.asked")
    assert not labelling.session.written


@needs_browser
def test_hardness_follows_the_object_in_the_form(labelling: Labelling, chromium: Any) -> None:
    from selenium.webdriver.common.keys import Keys

    def label(*keys: str) -> str:
        press(chromium, "o")
        press(chromium, *keys)
        shore = chromium.execute_script("return document.getElementById('shore').value")
        press(chromium, Keys.ENTER)
        until(chromium, lambda d: d.execute_script("return form.hidden"))
        return str(shore)

    chromium.get(labelling.server.url)
    counts(chromium, "10 open")
    assert label("eraser", Keys.TAB, "40") == "40"
    until(chromium, lambda d: "eraser, 40 Shore A" in text(d, "what"))
    press(chromium, " ", " ")
    # Another object does not inherit the hardness, and one that was labelled brings its own.
    assert label("foam") == ""
    until(chromium, lambda d: text(d, "what").startswith("foam: "))
    press(chromium, " ")
    assert label("eraser") == "40"
    until(chromium, lambda d: "eraser, 40 Shore A" in text(d, "what"))


@needs_browser
def test_values_stand_beside_the_signal(labelling: Labelling, chromium: Any) -> None:
    chromium.get(labelling.server.url)
    counts(chromium, "10 open")
    until(chromium, lambda d: d.execute_script("return state.shown === current().number"))
    shown = chromium.execute_script(
        "const pen = CanvasRenderingContext2D.prototype, write = pen.fillText, said = [];"
        "pen.fillText = (text) => said.push(text); draw(); pen.fillText = write; return said;"
    )
    values = [float(s.replace("−", "-")) for s in shown if not re.search("[a-z]", s)]
    at = int(taps(10)[0])
    signal = labelling.data[at - 160 : at + 161]
    assert len(values) > 3
    assert signal.min() <= min(values) <= signal.min() / 2
    assert signal.max() / 2 <= max(values) <= signal.max()
    assert "disc, V" in shown


@needs_browser
def test_one_goes_back_to_a_signal_that_the_page_has_forgotten(
    tmp_path: Path, chromium: Any
) -> None:
    from selenium.webdriver.common.keys import Keys

    labelling = Labelling(tmp_path, 420, every=0.12)
    chromium.get(labelling.server.url)
    counts(chromium, "420 open")
    for _ in range(42):
        press(chromium, *([Keys.ARROW_RIGHT] * 10))
        until(chromium, lambda d: d.execute_script("return state.shown === current().number"))
    press(chromium, Keys.HOME)
    until(chromium, lambda d: d.execute_script("return state.shown === 0"))
    labelling.close()


@needs_browser
def test_what_the_disk_refuses_is_not_shown_as_done(labelling: Labelling, chromium: Any) -> None:
    chromium.get(labelling.server.url)
    counts(chromium, "10 open")
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    size = (labelling.out / "labels.jsonl").stat().st_size
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, limits[1]))
    try:
        press(chromium, " ")
        until(chromium, lambda d: "cannot be written" in text(d, "said"))
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
    counts(chromium, "0 accepted, 0 rejected, 10 open")


def test_other_sites_and_names_get_nothing(labelling: Labelling) -> None:
    port = labelling.port
    assert ask(port, "/")[0] == 200
    assert ask(port, "/", host="evil.example")[0] == 403
    assert ask(port, "/labels.jsonl")[0] == 404
    head = {**UPGRADE, "Origin": "http://evil.example"}
    assert ask(port, "/socket", **head)[0] == 403
    assert ask(port, "/socket", **UPGRADE)[0] == 101
    assert ask(port, "/")[1].count("Content-Security-Policy") == 1


def test_ctrl_c_while_pages_ask_ends_in_one_sentence(tmp_path: Path) -> None:
    path, out = write_taps(tmp_path / "taps.mcap", 20), tmp_path / "out"
    words = ["label", str(path), "--out", str(out), "--no-browser"]
    answered = threading.Semaphore(0)

    def ask_on(url: str) -> None:
        with connect(url) as page, suppress(ConnectionClosed):
            page.recv()
            while True:
                page.send(json.dumps({"ask": "signal", "sample": 9000, "half": 2.0}))
                page.recv()
                answered.release()

    command = [sys.executable, "-m", "firstcontact.cli.main", *words]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        assert process.stdout
        assert b"20 onsets" in process.stdout.readline()
        address = process.stdout.readline().split()[2].decode().replace("http:", "ws:")
        pages = [threading.Thread(target=ask_on, args=(f"{address}socket",)) for _ in range(3)]
        for page in pages:
            page.start()
        for _ in range(60):
            assert answered.acquire(timeout=60)
        process.send_signal(signal.SIGINT)
        _, said = process.communicate(timeout=60)
        for page in pages:
            page.join(60)
    assert process.returncode == 130
    assert said.count(b"\n") == 1, said.decode()
    assert said.startswith(b"firstcontact: ")
