"""Workers: order, errors, and none left behind."""

from __future__ import annotations

import os
import signal
from pathlib import Path

import pytest

from firstcontact.study.jobs import Serial, parallel, terminations_interrupt


def test_results_come_in_order_and_workers_end() -> None:
    ticks: list[tuple[int, int]] = []
    with parallel(2, lambda done, total: ticks.append((done, total))) as runner:
        assert runner.map(abs, [-1, 2, -3]) == Serial().map(abs, [-1, 2, -3]) == [1, 2, 3]
        pids = set(runner.map(_pid, [0, 1, 2, 3]))
    assert ticks[:3] == [(1, 3), (2, 3), (3, 3)]
    assert os.getpid() not in pids
    assert not any(_alive(pid) for pid in pids)


def _pid(_: int) -> int:
    return os.getpid()


def _alive(pid: int) -> bool:
    try:
        state = Path(f"/proc/{pid}/stat").read_text(encoding="utf-8").rsplit(")", 1)[1].split()[0]
    except FileNotFoundError:
        return False
    return state != "Z"


def test_an_error_in_a_worker_ends_the_map() -> None:
    with parallel(1) as runner, pytest.raises(ZeroDivisionError):
        runner.map((1.0).__truediv__, [1.0, 0.0])


def test_sigterm_is_an_interrupt() -> None:
    before = signal.getsignal(signal.SIGTERM)
    with pytest.raises(KeyboardInterrupt), terminations_interrupt():
        os.kill(os.getpid(), signal.SIGTERM)
    assert signal.getsignal(signal.SIGTERM) is before
