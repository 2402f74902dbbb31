"""Guided recording in a terminal: prompts and the Enter key."""

import os

import numpy as np
import pytest

from firstcontact.cli.guided import REMIND, Terminal, entered
from firstcontact.cli.stopping import Stop
from firstcontact.collect.guide import Guide, Item, Judged
from firstcontact.core import (
    Block,
    Calibration,
    Finger,
    InputError,
    VibrationCalibration,
    fingertip_layout,
)
from firstcontact.device import Arrival, Health

LAYOUT = fingertip_layout()
CALIBRATION = Calibration(tuple(VibrationCalibration(f, 0.002) for f in Finger))
BLOCK = Item("block 29", 5, 29.0, "b29")
APPLE = Item("apple", 5)
LABEL = BLOCK.label("1")


class Counts:
    """Minimal source of samples, with the counts that the guide in the terminal reads."""

    health = Health(samples=1000, lost_samples=7)


@pytest.fixture
def typed(monkeypatch):
    """Replace standard input by a pipe, and return its writing end."""
    present, positions = os.pipe()
    with os.fdopen(present) as stdin, os.fdopen(positions, "w") as keys:
        monkeypatch.setattr("sys.stdin", stdin)
        yield keys


def guide(layout=LAYOUT, calibration=CALIBRATION):
    return Guide(layout, (BLOCK, APPLE), "1", calibration)


def begun(source, guide, asks=False):
    """Return a terminal that shows the progress of a guide."""
    terminal = Terminal(source, Stop(), asks)
    terminal.begin(guide)
    return terminal


def test_enter_counts_once_without_blocking(typed):
    assert not entered()
    typed.write("\n")
    typed.flush()
    assert entered()
    assert not entered()
    typed.close()
    with pytest.raises(InputError, match="standard input has ended"):
        entered()


@pytest.mark.parametrize("asks", [False, True])
def test_the_next_object_is_awaited_if_a_person_places_it(capsys, asks):
    terminal = begun(Counts(), guide(), asks)
    assert terminal.next_object(LABEL, 2, 5) is not asks
    assert ("Enter" in capsys.readouterr().out) is asks


def test_every_pinch_and_each_change_of_the_link_is_one_line(capsys):
    source = Counts()
    source.health = Health(connected=True, samples=1000)
    terminal = begun(source, guide())
    terminal.judged(Judged(LABEL, (), None, 3, 5, 0.0165, -0.0004, 1.02))
    terminal.judged(Judged(LABEL, ("samples were lost", "it clipped"), None, 3, 5, 0, 0, 1.0))
    source.health = Health(connected=False, samples=1000)
    terminal.going_on()
    terminal.going_on()
    source.health = Health(True, 1, samples=1100, lost_samples=400, reconnects=1)
    terminal.going_on()
    terminal.end()
    good, bad, _gone, _back, loss, counts, _warning = capsys.readouterr().out.splitlines()
    assert "block 29 3/5" in good
    assert "samples were lost; it clipped" in bad
    assert "400" in loss
    assert all(number in counts for number in ("1100", "400", "1"))


def test_a_hand_that_does_not_close_is_asked_for_and_noise_is_blamed_where_it_is(capsys):
    source, watching = Counts(), guide()
    terminal = begun(source, watching)
    data = np.zeros((2000, 16), np.int16)
    noise = np.random.default_rng(0).normal(0, 0.005, (2000, 2))
    data[:, :2] = noise / LAYOUT.channels[0].scale + LAYOUT.channels[0].offset
    watching.update(Arrival(Block(data), 0.0))
    terminal.going_on()
    assert capsys.readouterr().out == ""
    samples = 1000 + round(REMIND * LAYOUT.rate) + 1
    source.health = Health(samples=samples, lost_samples=7)
    terminal.going_on()
    terminal.going_on()
    (line,) = capsys.readouterr().out.splitlines()
    assert "calibrate" in line
