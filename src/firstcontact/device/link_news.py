"""What has become of a link since it was last looked at, in words."""

from __future__ import annotations

from firstcontact.device.source import Health


def link_news(before: Health, now: Health) -> list[str]:
    """A line each for a device that went, one that came back, and samples lost."""
    news = []
    if before.connected and not now.connected:
        news.append("link: the device is gone; waiting for it")
    if now.reconnects > before.reconnects:
        news.append(f"link: the device is back, epoch {now.epoch}")
    elif now.connected and not before.connected:
        news.append("link: the device is back")
    lost = now.lost_samples - before.lost_samples
    if lost > 0:
        news.append(f"link: {lost} samples lost, {now.lost_samples} in all")
    return news
