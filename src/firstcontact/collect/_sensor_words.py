"""Messages about vibration sensors: requests to keep still, and measurements with units."""

from __future__ import annotations

from firstcontact.core import Channel, Layout, VibrationCalibration


def measured_channel(layout: Layout, measured: VibrationCalibration) -> Channel | None:
    """Return the channel that was measured; None if the layout has no channel of that finger."""
    return next((c for c in layout.vibration if c.finger is measured.finger), None)


def is_tapped(layout: Layout) -> bool:
    """Return True if no sensor belongs to a finger: a person taps a disc, and no motor closes."""
    return all(finger is None for finger in layout.vibration_fingers)


def rest_request(layout: Layout) -> str:
    """Return the request to keep the hand still while the noise floor is measured."""
    return "touch nothing" if is_tapped(layout) else "keep the hand open and still, motor off"


def rest_words(measured: VibrationCalibration, channel: Channel | None) -> str:
    """Return a sentence with the noise and the mean (offset) of a sensor at rest."""
    if channel is None or channel.unit == "V":
        noise, offset = 1e3 * measured.noise, 1e3 * measured.offset
        return f"noise {noise:.2f} mV RMS, offset {offset:+.2f} mV"
    unit = _unit(channel)
    return f"noise {measured.noise:.3g} {unit} RMS, offset {measured.offset:+.3g} {unit}"


def tap_words(tap: float, channel: Channel | None) -> str:
    """Return a sentence with the peak of a tap."""
    return f"tap {tap:.3f} {'V' if channel is None else _unit(channel)}"


def _unit(channel: Channel) -> str:
    return "of full scale" if channel.unit == "full scale" else channel.unit
