"""Tests of the messages about a link."""

from __future__ import annotations

from firstcontact.device import Health, LinkNews
from firstcontact.device._link_news import MERGE_TIME


def test_losses_that_follow_one_another_are_a_line_a_second_and_none_is_left_out() -> None:
    now = [0.0]
    link = LinkNews(Health(True), clock=lambda: now[0])
    said = []
    for k in range(50):
        now[0] = k * MERGE_TIME / 20
        said += link.lines(Health(True, lost_samples=7 * (k + 1)))
    assert len(said) == 3
    assert said[0] == "link: 7 samples lost, 7 in all"
    said += link.lines(Health(True, lost_samples=350), last=True)
    told = [int(line.split()[1]) for line in said]
    assert sum(told) == 350
    assert said[-1].endswith(", 350 in all")
    assert link.lines(Health(True, lost_samples=350), last=True) == []


def test_a_device_that_goes_is_told_at_once_while_losses_are_gathered() -> None:
    link = LinkNews(Health(True), clock=lambda: 0.0)
    assert len(link.lines(Health(True, lost_samples=5))) == 1
    gone = link.lines(Health(False, lost_samples=9))
    assert gone == ["link: the device is gone; waiting for it"]
    assert link.lines(Health(False, lost_samples=9), last=True) == [
        "link: 4 samples lost, 9 in all"
    ]


def test_a_stream_that_is_no_longer_usable_is_not_called_gone() -> None:
    for health in (Health(False, unusable_samples=9), Health(False, bad_frames=9)):
        link = LinkNews(Health(True), clock=lambda: 0.0)
        assert link.lines(health) == ["link: the samples are not usable; waiting for it"]
