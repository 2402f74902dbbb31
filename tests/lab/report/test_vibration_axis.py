"""The vibration axes of the figures have the unit of the data."""

from __future__ import annotations

from firstcontact.core import Channel, ChannelKind, Finger, Layout, fingertip_layout
from firstcontact_lab.report.style import vibration_axis


def test_only_volts_become_millivolts() -> None:
    other = Layout((Channel("p", ChannelKind.VIBRATION, Finger.INDEX, "full scale"),), 4936.0)
    assert vibration_axis(other, milli=True) == vibration_axis(other) == ("Piezo (full scale)", 1.0)
    assert vibration_axis(fingertip_layout(), milli=True) == ("Piezo (mV)", 1e3)
    assert vibration_axis(fingertip_layout()) == ("Piezo (V)", 1.0)
