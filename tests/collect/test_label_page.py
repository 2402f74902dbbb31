"""The labelling page in a real browser, operated by its keys."""

import json
import signal
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest
from taps import PIEZO, RATE, taps, write_taps
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import connect

from firstcontact.collect.label_result import Labeller
from firstcontact.collect.label_session import LabelServer, Session, open_recordings
from firstcontact.recording import load_dataset
from page_browser import UPGRADE, ask, browsing, needs_browser, text, until
from processes import full_disk


class Labelling:
    """Labelling page that a thread serves until labelling is finished."""

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
        self.stopping = threading.Event()
        until = ready.set, self.stopping.is_set
        self.thread = threading.Thread(target=self.server.run, args=until, daemon=True)
        self.thread.start()
        assert ready.wait(30)

    def close(self) -> None:
        self.stopping.set()
        self.thread.join(30)
        self.session.close()

    @property
    def port(self) -> int:
        return int(self.server.url.rstrip("/").rpartition(":")[2])


@pytest.fixture
def labelling(tmp_path: Path) -> Iterator[Labelling]:
    open_labelling = Labelling(tmp_path, 10)
    yield open_labelling
    open_labelling.close()


@pytest.fixture(scope="module")
def chromium(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    with browsing(tmp_path_factory.mktemp("profile")) as driver:
        yield driver


def press(driver: Any, *keys: str) -> None:
    from selenium.webdriver.common.action_chains import ActionChains

    ActionChains(driver).send_keys(*keys).perform()


def wait_for_counts(driver: Any, expected: str) -> None:
    until(driver, lambda d: expected in text(d, "counts"))


@needs_browser
def test_keys_alone_label_a_recording(labelling: Labelling, chromium: Any) -> None:
    from selenium.webdriver.common.keys import Keys

    chromium.get(labelling.server.url)
    wait_for_counts(chromium, "10 undecided")
    press(chromium, "o")
    press(chromium, "eraser", Keys.TAB, "40", Keys.ENTER)
    until(chromium, lambda d: "eraser, 40 Shore A" in text(d, "what"))
    press(chromium, " ", " ", "x", " ")
    wait_for_counts(chromium, "3 accepted, 1 rejected, 6 undecided")
    press(chromium, "u")
    wait_for_counts(chromium, "2 accepted, 1 rejected, 7 undecided")
    press(chromium, ">", ".")
    until(chromium, lambda d: "moved by 1.13 ms" in text(d, "what"))
    press(chromium, Keys.TAB, "+", "-", "-")
    # Nothing is added where the signal that is pointed at has not come yet.
    until(chromium, lambda d: d.execute_script("return drawn()"))
    press(chromium, "n")
    wait_for_counts(chromium, "4 accepted")
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
def test_buttons_label_on_a_telephone(labelling: Labelling, chromium: Any) -> None:
    from selenium.webdriver.common.actions.action_builder import ActionBuilder
    from selenium.webdriver.common.actions.interaction import POINTER_TOUCH
    from selenium.webdriver.common.actions.pointer_input import PointerInput

    def click(key: str) -> None:
        chromium.find_element("css selector", f"button[data-key='{key}']").click()

    usual = chromium.get_window_size()
    chromium.set_window_size(400, 800)
    chromium.get(labelling.server.url)
    wait_for_counts(chromium, "10 undecided")
    width = "return [document.documentElement.scrollWidth, window.innerWidth]"
    needed, available = chromium.execute_script(width)
    assert needed <= available
    for button in chromium.find_elements("css selector", ".keys button"):
        assert button.rect["height"] >= 40
    click(" ")
    click("x")
    wait_for_counts(chromium, "1 accepted, 1 rejected, 8 undecided")
    press(chromium, " ")  # a key still belongs to the page, not to the button
    wait_for_counts(chromium, "2 accepted, 1 rejected, 7 undecided")
    until(chromium, lambda d: d.execute_script("return drawn()"))
    click("n")
    signal = chromium.find_element("id", "plot")
    finger = ActionBuilder(chromium, mouse=PointerInput(POINTER_TOUCH, "finger"))
    finger.pointer_action.move_to(signal, x=100, y=0).pointer_down().pointer_up()
    finger.perform()
    wait_for_counts(chromium, "3 accepted, 1 rejected, 7 undecided")
    added = max(labelling.session.marks.ordered(), key=lambda mark: mark.number)
    assert added.sample - taps(10)[3] == pytest.approx(100 / 360 * 0.04 * RATE, abs=30)
    chromium.set_window_size(usual["width"], usual["height"])


@needs_browser
def test_key_after_undo_labels_the_reopened_onset(labelling: Labelling, chromium: Any) -> None:
    chromium.get(labelling.server.url)
    wait_for_counts(chromium, "10 undecided")
    press(chromium, " ", " ", "u", "x", " ")
    wait_for_counts(chromium, "2 accepted, 1 rejected, 7 undecided")
    statuses = [m.status.value for m in labelling.session.marks.ordered()[:4]]
    assert statuses == ["accepted", "rejected", "accepted", "found"]
    press(chromium, "u", "u")
    until(chromium, lambda d: "onset 2 of 10" in text(d, "place"))
    assert "undecided" in text(chromium, "what")


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
    wait_for_counts(chromium, "10 undecided")
    assert label("eraser", Keys.TAB, "40") == "40"
    until(chromium, lambda d: "eraser, 40 Shore A" in text(d, "what"))
    press(chromium, " ", " ")
    # Another object does not inherit the hardness, and one that was labelled brings its own.
    assert label("foam") == ""
    until(chromium, lambda d: text(d, "what").startswith("foam: "))
    press(chromium, " ")
    assert label("eraser") == "40"
    until(chromium, lambda d: "eraser, 40 Shore A" in text(d, "what"))
    press(chromium, " ")
    assert label("spring", Keys.TAB, "15", Keys.TAB, "N") == "15"
    until(chromium, lambda d: "spring, 15 N/mm" in text(d, "what"))


@needs_browser
def test_failed_write_is_not_shown_as_a_label(labelling: Labelling, chromium: Any) -> None:
    chromium.get(labelling.server.url)
    wait_for_counts(chromium, "10 undecided")
    with full_disk((labelling.out / "labels.jsonl").stat().st_size):
        press(chromium, " ")
        until(chromium, lambda d: "cannot be written" in text(d, "said"))
    wait_for_counts(chromium, "0 accepted, 0 rejected, 10 undecided")


def test_requests_from_other_sites_are_refused(labelling: Labelling) -> None:
    port = labelling.port
    assert ask(port, "/")[0] == 200
    assert ask(port, "/", host="evil.example")[0] == 403
    assert ask(port, "/labels.jsonl")[0] == 404
    head = {**UPGRADE, "Origin": "http://evil.example"}
    assert ask(port, "/socket", **head)[0] == 403
    assert ask(port, "/socket", **UPGRADE)[0] == 101
    assert ask(port, "/")[1].count("Content-Security-Policy") == 1


def test_ctrl_c_during_requests_exits_cleanly(tmp_path: Path) -> None:
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
        _, error = process.communicate(timeout=60)
        for page in pages:
            page.join(60)
    assert process.returncode == 130
    assert error.count(b"\n") == 1, error.decode()
    assert error.startswith(b"firstcontact: ")
