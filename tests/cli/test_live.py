"""``firstcontact live`` as a user runs it: a process, the twin on its terminal, signals."""

import json
import os
import signal
import subprocess
import urllib.request
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from websockets.sync.client import connect

import forked
from emulated_ability import EmulatedAbility
from firstcontact.cli.main import main
from firstcontact.grasp.ability import NEARLY_OPEN
from firstcontact.recording import read_recording
from processes import ON_FULL_DISK

#: Longest wait for a process, s: only a failing test ever waits so long.
LONG = 240.0


@pytest.fixture(scope="module")
def environment(user_cache: Path) -> dict[str, str]:
    """Environment variables with a separate cache."""
    return {**os.environ, "XDG_CACHE_HOME": str(user_cache)}


def live(environment: dict[str, str], *arguments: str) -> subprocess.CompletedProcess[str]:
    return forked.firstcontact("live", *arguments, env=environment)


def started(environment: dict[str, str], *arguments: str, **streams: int) -> forked.Program:
    return forked.Program("command", "live", *arguments, env=environment, **streams)


def estimates(text: str) -> list[tuple[float, ...]]:
    """Return the numbers of the estimates in JSON lines, without the host's clock."""
    events = [json.loads(line) for line in text.splitlines()]
    return [
        (e["final"], e["contact"]["sample"], e["complete"], e["value"], e["low"], e["high"])
        for e in events
        if e["type"] == "estimate"
    ]


def same(one: list[tuple[float, ...]], other: list[tuple[float, ...]]) -> bool:
    """Return True if all estimates agree to a few digits.

    If several estimates are due at once, they are computed by one matrix product, so their last
    digits can differ.
    """
    return one == [pytest.approx(numbers, rel=0, abs=1e-3) for numbers in other]


@pytest.fixture(scope="module")
def recorded(
    environment: dict[str, str], tmp_path_factory: pytest.TempPathFactory
) -> tuple[Path, list[tuple[float, ...]]]:
    """Return a recording made by a live run, and the estimates of that run."""
    folder = tmp_path_factory.mktemp("recordings")
    arguments = ("--pinches", "4", "--speed", "4", "--record", "--recordings", str(folder))
    process = live(environment, "--device", "twin", "--json", *arguments)
    assert process.returncode == 0, process.stderr
    return next(folder.glob("*.mcap")), estimates(process.stdout)


def test_the_twin_is_seen_and_recorded(recorded: tuple[Path, list[tuple[float, ...]]]) -> None:
    path, predictions = recorded
    # The network predicts each millisecond until the second contact.
    assert len(predictions) > 8
    recording = read_recording(path)
    assert recording.skipped == ()
    assert recording.header.source == "twin"
    assert recording.header.calibration is not None
    assert [m.text for m in recording.markers if m.text.startswith("twin: ")]
    assert [len(m.truth) for m in recording.pinches] == [2] * 4


def test_a_replay_tells_what_was_told_live(
    environment: dict[str, str], recorded: tuple[Path, list[tuple[float, ...]]]
) -> None:
    path, predictions = recorded
    again = live(environment, "--device", str(path), "--speed", "inf", "--json")
    assert again.returncode == 0, again.stderr
    assert same(estimates(again.stdout), predictions)


@pytest.mark.parametrize(
    ("number", "code"),
    # A terminal that is closed, and SIGQUIT, are no success.
    [
        (signal.SIGINT, 0),
        (signal.SIGTERM, 0),
        pytest.param(signal.SIGHUP, 129, marks=pytest.mark.slow),
        pytest.param(signal.SIGQUIT, 131, marks=pytest.mark.slow),
    ],
)
def test_a_signal_ends_it_in_order(
    number: signal.Signals, code: int, environment: dict[str, str], tmp_path: Path
) -> None:
    arguments = ["--device", "twin", "--speed", "4", "--record", "--recordings", str(tmp_path)]
    process = started(environment, *arguments, stdout=subprocess.PIPE)
    for line in process.stdout:
        if line.startswith("pinch 2"):
            process.send_signal(number)
            break
    process.stdout.read()
    assert process.wait(LONG) == code
    process.stdout.close()
    (path,) = tmp_path.glob("*.mcap")
    assert read_recording(path).skipped == ()


def test_a_recording_that_breaks_off_is_told_and_shows_in_the_exit_code(
    environment: dict[str, str], tmp_path: Path
) -> None:
    arguments = ["live", "--device", "twin", "--speed", "4", "--seconds", "4"]
    arguments += ["--record", "--recordings", str(tmp_path)]
    process = forked.run("code", ON_FULL_DISK, 100_000, *arguments, env=environment)
    assert process.returncode == 2, process.stderr
    (path,) = tmp_path.glob("*.mcap")
    assert str(path) in process.stderr.splitlines()[-1]
    assert "make room" in process.stderr.splitlines()[-1]
    assert read_recording(path).samples > 0


def test_the_twins_hand_is_driven(environment: dict[str, str]) -> None:
    process = live(
        environment, "--device", "twin", "--hand", "twin", "--pinches", "2", "--json", "--speed=3"
    )
    assert process.returncode == 0, process.stderr
    # The device tells each command that it took, and how hard the hand squeezed.
    assert process.stdout.count('"twin: told hand: ') >= 4
    assert '"twin: peak ' in process.stdout
    assert "released 2 times" in process.stderr  # with the end, and when the connection is closed


@pytest.mark.parametrize(("number", "code"), [(signal.SIGTERM, 0), (signal.SIGQUIT, 131)])
def test_a_signal_releases_the_hand(
    number: signal.Signals, code: int, environment: dict[str, str]
) -> None:
    arguments = ["--device", "twin", "--hand", "print", "--policy", "touch", "--speed=4"]
    pipe = subprocess.PIPE
    process = started(environment, *arguments, stdout=pipe, stderr=pipe)
    for line in process.stdout:
        if line.startswith("pinch 1"):
            process.send_signal(number)
            break
    _, errors = process.communicate(timeout=LONG)
    assert process.returncode == code
    orders = [line for line in errors.splitlines() if line.startswith("hand ") and " s  " in line]
    assert orders[-1].endswith("release")


def test_an_output_that_cannot_be_written_is_no_success(environment: dict[str, str]) -> None:
    words = ("live", "--device", "twin", "--speed", "4", "--seconds", "20", "--json")
    with Path("/dev/full").open("w") as full:
        process = forked.firstcontact(*words, env=environment, stdout=full)
    assert process.returncode == 2, process.stderr
    assert "No space left" in process.stderr.splitlines()[-1]


@pytest.fixture
def paged(environment: dict[str, str]) -> Iterator[tuple[subprocess.Popen[str], str]]:
    arguments = ["--device", "twin", "--hand", "twin", "--page", "--port", "0"]
    process = started(environment, *arguments, stderr=subprocess.PIPE)
    address = next(line.split()[-1] for line in process.stderr if line.startswith("page: "))
    yield process, address
    process.send_signal(signal.SIGINT)
    process.communicate(timeout=LONG)


def test_the_page_is_where_it_says_and_closes_the_hand(
    paged: tuple[subprocess.Popen[str], str],
) -> None:
    process, address = paged
    assert process.stdout is None
    with urllib.request.urlopen(address, timeout=LONG) as answer:
        assert "firstcontact" in answer.read().decode().lower().replace(" ", "")
    with connect(address.replace("http", "ws") + "socket", compression=None) as viewer:
        state = json.loads(viewer.recv(timeout=LONG))
        assert state["hello"]["hand_asks"] == ["close", "open"]
        viewer.send('{"do": "close"}')
        seen: list[str] = []  # the reply, the command, and then the contact of its closing
        while seen[-1:] != ["now"]:
            message = viewer.recv(timeout=LONG)
            state = json.loads(message) if isinstance(message, str) else {}
            assert state.get("answer", {"ok": True})["ok"], state
            seen += [part for part in ("answer", "hand") if state.get(part)]
            if "hand" in seen and (state.get("now") or {}).get("estimates"):
                seen.append("now")
        assert sorted(seen) == ["answer", "hand", "now"]


@pytest.mark.parametrize(
    ("arguments", "word"),
    [
        (["--device", "/nowhere/tty"], "/nowhere/tty"),
        (["--device", "twin", "--speed", "0"], "--speed"),
        (["--device", "twin", "--seconds", "-1"], "--seconds"),
        (["--device", "twin", "--shape", "a ball"], "a ball"),
        (["--device", "twin", "--calibration", "none.json"], "none.json"),
        (["--device", "twin", "--model", "nowhere"], "nowhere"),
        (["--device", "twin", "--hand", "nobody's"], "nobody's"),
        (["--device", "twin", "--policy", "early_exit"], "--policy: "),
        (["--device", "twin", "--hand-port", "/nowhere/tty"], "--hand-port: "),
        (["--device=twin", "--slip=power", "--hand=print", "--policy=touch"], "--slip: "),
    ],
)
def test_what_cannot_be_used_is_said_in_one_sentence(
    arguments: list[str],
    word: str,
    environment: dict[str, str],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("XDG_CACHE_HOME", environment["XDG_CACHE_HOME"])
    assert main(["live", *arguments]) == 2
    errors = capsys.readouterr().err.strip().splitlines()
    assert errors[-1].startswith("firstcontact: ")
    assert word in errors[-1]
    assert list(tmp_path.iterdir()) == []


@contextmanager
def closing_by_lines(
    environment: dict[str, str], port: Path
) -> Iterator[tuple[EmulatedAbility, subprocess.Popen[str]]]:
    """Start ``live`` and close the hand by a line on its standard input."""
    arguments = ["--device", "twin", "--hand", "ability", "--hand-port", str(port), "--json"]
    pipe, nowhere = subprocess.PIPE, subprocess.DEVNULL
    with (
        EmulatedAbility(port) as hand,
        started(environment, *arguments, stdin=pipe, stdout=pipe, stderr=nowhere) as process,
    ):
        try:
            assert "descriptor" in process.stdout.readline()
            hand.wait(lambda h: h.open)
            ask(process, "close")
            hand.wait(is_closing)
            yield hand, process
        finally:
            process.kill()


def ask(process: subprocess.Popen[str], line: str) -> None:
    process.stdin.write(f"{line}\n")
    process.stdin.flush()


def is_closing(hand: EmulatedAbility) -> bool:
    return min(hand.position[0], hand.position[4]) > NEARLY_OPEN


def test_lines_close_and_open_a_hand_and_their_end_opens_it(
    environment: dict[str, str], tmp_path: Path
) -> None:
    with closing_by_lines(environment, tmp_path / "ttyHand") as (hand, process):
        ask(process, "open")
        hand.wait(lambda h: h.open)
        ask(process, "close")
        hand.wait(is_closing)
        process.stdin.close()
        hand.wait(lambda h: h.open)
        predictions: list[tuple[str, str]] = []
        for event in map(json.loads, process.stdout):
            if event["type"] == "hand_command":
                predictions.append((event["ask"], event["by"]))
                if len(predictions) == 4:  # the hand may be open before its event is out
                    process.send_signal(signal.SIGTERM)
        assert process.wait(LONG) == 0
    by = "standard input"
    assert predictions == [("close", by), ("open", by), ("close", by), ("open", by)]
