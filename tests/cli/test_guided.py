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
    Channel,
    ChannelKind,
    Finger,
    InputError,
    Layout,
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
def test_the_next_object_is_named_and_awaited_if_a_person_places_it(capsys, asks):
    terminal = begun(Counts(), guide(), asks)
    assert terminal.next_object(LABEL, 2, 5) is not asks
    output = capsys.readouterr().out
    assert "next: block 29, 29 Shore A, specimen b29, 3 of 5 pinches to go" in output
    assert ("press Enter" in output) is asks


def test_every_pinch_is_one_line_with_all_that_was_checked(capsys):
    terminal = begun(Counts(), guide())
    terminal.judged(Judged(LABEL, (), None, 3, 5, 0.0165, -0.0004, 1.02))
    terminal.judged(Judged(LABEL, ("samples were lost", "it clipped"), None, 3, 5, 0, 0, 1.0))
    terminal.end()
    assert capsys.readouterr().out.splitlines() == [
        "block 29 3/5: contact, strip and piezo agree to 0.4 ms, offset 16.5 ms, "
        "noise 1.02 x floor, 7 samples lost so far",
        "block 29: does not count: samples were lost; it clipped",
        "link: 1000 samples, 7 lost, 0 damaged frames, 0 reconnects; 0 closings did not count",
    ]


def test_a_link_that_goes_and_comes_is_said_once_each(capsys):
    source = Counts()
    source.health = Health(connected=True, samples=1000)
    terminal = begun(source, guide())
    terminal.going_on()
    source.health = Health(connected=False, samples=1000)
    terminal.going_on()
    terminal.going_on()
    source.health = Health(True, 1, samples=1100, lost_samples=400, reconnects=1)
    terminal.going_on()
    terminal.going_on()
    terminal.end()
    assert capsys.readouterr().out.splitlines()[:-1] == [
        "link: the device is gone; waiting for it",
        "link: the device is back, epoch 1",
        "link: 400 samples lost, 400 in all",
        "link: 1100 samples, 400 lost, 0 damaged frames, 1 reconnects; 0 closings did not count",
    ]


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
    assert line.startswith("waiting for the hand to close; noise 2.")
    assert line.endswith(": calibrate again, or quieten the hand")


def test_a_sensor_of_no_finger_waits_for_taps(capsys):
    layout = Layout((Channel("disc", ChannelKind.VIBRATION, None, "V"),), LAYOUT.rate)
    calibration = Calibration((VibrationCalibration(None, 0.002),))
    source = Counts()
    terminal = begun(source, guide(layout, calibration))
    source.health = Health(samples=1000 + round(REMIND * LAYOUT.rate) + 1, lost_samples=7)
    terminal.going_on()
    terminal.end()
    waiting, closing = capsys.readouterr().out.splitlines()
    assert waiting.startswith("waiting for a tap; ")
    assert closing.endswith("; 0 taps did not count")
