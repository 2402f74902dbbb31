"""Example data: simulated pinches, and simulated strikes of one finger on a block."""

from __future__ import annotations

from dataclasses import replace
from importlib.metadata import version
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import (
    ArgumentError,
    Channel,
    ChannelKind,
    Contact,
    Dataset,
    Label,
    Layout,
    Pinch,
    VibrationSensor,
)
from firstcontact.core.files import cache_path, make_once
from firstcontact.core.layout import FINGERTIP_RATE, PIEZO_OFFSET_VOLTS
from firstcontact.recording import Header, write_dataset
from firstcontact.recording.dataset import load
from firstcontact.twin.draw import CONDITIONS, condition, draw_pinch
from firstcontact.twin.mechanics import BUFFER, INDENTATION
from firstcontact.twin.objects import BLOCKS, block
from firstcontact.twin.pinch import integrate_pinch
from firstcontact.twin.simulation import simulate_recordings

#: Version of the twin, the training and the model format; a new one replaces cached models and
#: sample data.
RECIPE = 7
#: Length of a strike before and after its contact, s.
BEFORE, AFTER = 0.06, 0.09
#: Noise of a cheap sound input, as a share of full scale.
NOISE = 0.0013


def strike(shore_a: float, number: int, seed: int) -> tuple[NDArray[np.float64], int]:
    """Return the signal of one simulated strike on a block, and the sample of its contact.

    The full scale of the signal is 1.
    """
    draw = draw_pinch(seed, condition("paper-rig"), "1", block(shore_a), number)
    still = {"rotor": 0.0, "mesh": 0.0, "friction": 0.0, "click_rate": 0.0, "mains": 0.0}
    index, thumb = (replace(noise, **still, hum=0.0) for noise in draw.noise)
    timing = draw.timing._replace(first=BEFORE, second=BEFORE + 2 * AFTER, first_is_index=True)
    _, motion = integrate_pinch(
        replace(draw, noise=(index, thumb), timing=timing), duration=BEFORE + AFTER
    )
    signal = motion[:, 0, BUFFER] / PIEZO_OFFSET_VOLTS
    ends = np.ones(len(signal))
    fade = round(0.02 * FINGERTIP_RATE)
    ends[:fade], ends[-fade:] = np.linspace(0, 1, fade), np.linspace(1, 0, fade)
    return np.asarray(signal * ends), int(np.argmax(motion[:, 0, INDENTATION] > 0))


def strikes(each: int, seed: int) -> Dataset:
    """Return ``each`` strikes on each of five blocks, as a piezo at a sound input records them."""
    piezo = VibrationSensor.PIEZO
    channel = Channel(piezo, ChannelKind.VIBRATION, None, "full scale", 1.0, 0.0, sensor=piezo)
    layout, rng = Layout((channel,), FINGERTIP_RATE), np.random.default_rng(seed)
    pinches: list[Pinch] = []
    for target in BLOCKS:
        for number in range(each):
            signal, contact = strike(target.shore_a, number, seed)
            data = (signal + NOISE * rng.standard_normal(len(signal)))[:, None].astype(np.float32)
            # Strikes are one second apart.
            start = round(len(pinches) * FINGERTIP_RATE)
            label = Label(target.name, target.shore_a, specimen=target.name, session="strikes")
            truth = (Contact(None, start + contact, start + contact),)
            pinches.append(Pinch(data, layout, label, start, truth))
    return Dataset(tuple(pinches), "twin")


def sample(name: Literal["paper-rig", "everyday", "strikes"] = "paper-rig") -> Dataset:
    """Return simulated example data. The first call simulates them and stores them on disk.

    Parameters
    ----------
    name
        "paper-rig" or "everyday": 190 labelled pinches as :func:`simulate` makes them with that
        ``condition``. "strikes": 60 strikes on five blocks, heard by one piezo at a sound input.

    Returns
    -------
    Dataset
        Simulated pinches or strikes. Their recordings are in ``~/.cache/firstcontact``.

    Raises
    ------
    InputError
        No example data have that name.

    Examples
    --------
    >>> import firstcontact as fc
    >>> fc.sample("strikes")
    Dataset(60 pinches, 5 objects, 1 session, 4936 Hz, source='twin')
    """
    names = (*CONDITIONS, "strikes")
    if name not in names:
        raise ArgumentError(
            f"example data {name!r} are not known: use one of {', '.join(names)}", parameter="name"
        )
    folder = cache_path(f"sample-{version('firstcontact')}.{RECIPE}-{name}")

    def make(making: Path) -> None:
        if name == "strikes":
            made = strikes(12, seed=0)
            making.mkdir()
            write_dataset(made, making, Header(made.layout, source="twin", dtype="float32"))
        else:
            simulate_recordings(making, name, 30, 5, seed=0)

    make_once(folder, make)
    return load(folder)
