"""What was measured of a vibration sensor at rest, in words and in its own unit."""

from __future__ import annotations

from firstcontact.core import Channel, Layout, VibrationCalibration


def sensor_of(layout: Layout, measured: VibrationCalibration) -> Channel | None:
    """The channel that was measured; None where the layout has none of that finger."""
    return next((c for c in layout.vibration if c.finger is measured.finger), None)


def rest_words(measured: VibrationCalibration, channel: Channel | None) -> str:
    """Its noise and its offset."""
    if channel is None or channel.unit == "V":
        noise, offset = 1e3 * measured.noise, 1e3 * measured.offset
        return f"noise {noise:.2f} mV RMS, offset {offset:+.2f} mV"
    return (
        f"noise {measured.noise:.3g} {channel.unit} RMS, offset {measured.offset:+.3g} "
        f"{channel.unit}"
    )


def tap_words(tap: float, channel: Channel | None) -> str:
    """The peak of a tap."""
    return f"tap {tap:.3f} {'V' if channel is None else channel.unit}"
