"""The voltage of a taxel with a known weight on it."""

from __future__ import annotations

import numpy as np

from firstcontact.core import ChannelKind, Finger, InputError
from firstcontact.device import Source, wait_for_arrivals


def loaded_volts(source: Source, finger: Finger, seconds: float = 1.0) -> float:
    """Mean voltage of a finger's most loaded taxel, V.

    Parameters
    ----------
    source
        Open.
    finger
        Whose force is looked at.
    seconds
        Over this time, s of the device's.

    Raises
    ------
    InputError
        The finger has no force channel, or no samples come.
    """
    layout = source.descriptor.layout
    columns = layout.columns(ChannelKind.FORCE, finger)
    if not columns:
        raise InputError(f"the {finger.name.lower()} has no force channel: leave the weights out")
    total = np.zeros(len(columns))
    count = 0
    source.read(0)  # what came before the weight lay there
    while count < seconds * layout.rate:
        for arrival in wait_for_arrivals(source):
            volts = layout.physical(arrival.block.data, columns)
            total += volts.sum(axis=0)
            count += len(volts)
    return float((total / count).max())
