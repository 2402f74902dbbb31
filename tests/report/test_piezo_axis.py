"""Axes bear the unit of the data."""

from __future__ import annotations

from firstcontact.core import Channel, ChannelKind, Finger, Layout, fingertip_layout
from firstcontact.report.figures.style import piezo_axis


def test_only_volts_become_millivolts() -> None:
    other = Layout((Channel("p", ChannelKind.PIEZO, Finger.INDEX, "full scale"),), 4936.0)
    assert piezo_axis(other, milli=True) == piezo_axis(other) == ("Piezo (full scale)", 1.0)
    assert piezo_axis(fingertip_layout(), milli=True) == ("Piezo (mV)", 1e3)
    assert piezo_axis(fingertip_layout()) == ("Piezo (V)", 1.0)
