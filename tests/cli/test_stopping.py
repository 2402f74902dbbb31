"""A signal ends each verb once and in order. A hangup ends no verb that runs under nohup."""

import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from firstcontact.cli import stopping as module
from firstcontact.cli.stopping import stop_on_signals
from processes import until

SIGNALS = [signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT]
OTHERS = [signal.SIGINT, signal.SIGHUP, signal.SIGQUIT]
COMMAND = [sys.executable, "-m", "firstcontact.cli.main"]


@pytest.mark.parametrize("number", SIGNALS)
def test_a_signal_interrupts_once_and_its_repetition_disturbs_nothing(
    number: signal.Signals,
) -> None:
    previous = [signal.getsignal(n) for n in SIGNALS]
    ended = False
    with stop_on_signals() as stop:
        with pytest.raises(KeyboardInterrupt):
            signal.raise_signal(number)
        for again in SIGNALS:
            signal.raise_signal(again)
        ended = True
    assert ended
    assert (stop.signal, stop.code) == (number, 128 + number)
    assert [signal.getsignal(n) for n in SIGNALS] == previous


@pytest.mark.parametrize("number", SIGNALS)
def test_a_loop_that_looks_is_not_interrupted(number: signal.Signals) -> None:
    with stop_on_signals() as stop:
        stop.gently = True
        assert not stop.requested
        signal.raise_signal(number)
        signal.raise_signal(number)
        assert stop.requested


def test_who_insists_cuts_a_finishing_that_hangs_short(monkeypatch: pytest.MonkeyPatch) -> None:
    now = [100.0]
    monkeypatch.setattr(module.time, "monotonic", lambda: now[0])
    with stop_on_signals() as stop:
        stop.gently = True
        signal.raise_signal(signal.SIGINT)
        now[0] += module.INSISTED - 0.1
        signal.raise_signal(signal.SIGINT)
        now[0] += 0.2
        with pytest.raises(KeyboardInterrupt):
            signal.raise_signal(signal.SIGINT)
        signal.raise_signal(signal.SIGINT)


@pytest.fixture
def hung_up() -> Iterator[None]:
    """Ignore the hangup signal, as nohup does."""
    previous = signal.signal(signal.SIGHUP, signal.SIG_IGN)
    yield
    signal.signal(signal.SIGHUP, previous)


@pytest.mark.usefixtures("hung_up")
def test_what_is_ignored_stays_so() -> None:
    with stop_on_signals() as stop:
        signal.raise_signal(signal.SIGHUP)
        assert signal.getsignal(signal.SIGHUP) is signal.SIG_IGN
    assert not stop.requested


@pytest.mark.parametrize(
    "number", [signal.SIGTERM, *(pytest.param(n, marks=pytest.mark.slow) for n in OTHERS)]
)
def test_a_verb_that_writes_leaves_no_part(number: signal.Signals, tmp_path: Path) -> None:
    out = tmp_path / "set"
    with subprocess.Popen(
        [*COMMAND, "simulate", "--out", str(out), "--pinches-per-block", "500"],
        stderr=subprocess.PIPE,
    ) as process:
        # Pinches are being written; the whole set takes far longer.
        until(lambda: any(tmp_path.rglob("*.mcap*")))
        process.send_signal(number)
        output_tail = process.stderr.read()
    assert process.returncode == 128 + number
    assert output_tail.splitlines()[-1] == b"firstcontact: interrupted"
    assert list(tmp_path.iterdir()) == []
