"""Tests of the messages about a link."""

from __future__ import annotations

from firstcontact.device import Health
from firstcontact.device.source import MERGE_TIME, LinkNews


def test_repeated_losses_are_merged_into_a_line_per_second() -> None:
    now = [0.0]
    link = LinkNews(Health(True), clock=lambda: now[0])
    news = []
    for k in range(50):
        now[0] = k * MERGE_TIME / 20
        news += link.lines(Health(True, lost_samples=7 * (k + 1)))
    assert len(news) == 3
    assert news[0] == "link: 7 samples lost, 7 in all"
    news += link.lines(Health(True, lost_samples=350), last=True)
    loss_counts = [int(line.split()[1]) for line in news]
    assert sum(loss_counts) == 350
    assert news[-1].endswith(", 350 in all")
    assert link.lines(Health(True, lost_samples=350), last=True) == []


def test_disconnection_is_reported_immediately() -> None:
    link = LinkNews(Health(True), clock=lambda: 0.0)
    assert len(link.lines(Health(True, lost_samples=5))) == 1
    gone = link.lines(Health(False, lost_samples=9))
    assert gone == ["link: the device is gone; waiting for it"]
    assert link.lines(Health(False, lost_samples=9), last=True) == [
        "link: 4 samples lost, 9 in all"
    ]


def test_unusable_stream_is_not_reported_as_disconnected() -> None:
    for health in (Health(False, unusable_samples=9), Health(False, bad_frames=9)):
        link = LinkNews(Health(True), clock=lambda: 0.0)
        assert link.lines(health) == [
            "link: the samples are not usable; waiting for usable samples"
        ]
