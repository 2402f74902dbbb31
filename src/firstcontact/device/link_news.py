"""What has become of a link since it was last looked at, in words."""

from __future__ import annotations

from firstcontact.device.source import Health


def link_news(before: Health, now: Health) -> list[str]:
    """A line each for a device that went, one that came back, and samples lost."""
    news = []
    if before.connected and not now.connected:
        gone = "the device is gone; waiting for it"
        news.append(f"link: {'that was all of the recording' if now.ended else gone}")
    if now.reconnects > before.reconnects:
        news.append(f"link: the device is back, epoch {now.epoch}")
    elif now.connected and not before.connected:
        news.append("link: the device is back")
    lost = now.lost_samples - before.lost_samples
    if lost > 0:
        news.append(f"link: {lost} samples lost, {now.lost_samples} in all")
    return news


def clock_line(health: Health, rate: float) -> str:
    """How far the device's clock is off the host's, "" before it can be told.

    Parameters
    ----------
    health
        Of the source.
    rate
        That it says it has, Hz.
    """
    if not health.host_rate > 0:
        return ""
    off = 1e6 * (health.host_rate / rate - 1)
    return f"clock: {health.host_rate:.2f} samples a second of the host's clock, {off:+.0f} ppm"
