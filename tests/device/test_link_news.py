"""Tests of the messages about a link."""

import re

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
    news += link.lines(Health(True, lost_samples=350), last=True)
    losses = [[int(n) for n in re.findall(r"\d+", line)] for line in news]
    assert sum(lost for lost, _ in losses) == losses[-1][1] == 350
    assert link.lines(Health(True, lost_samples=350), last=True) == []


def test_disconnection_and_unusable_samples_are_reported_immediately() -> None:
    for change in ({}, {"unusable_samples": 9}, {"bad_frames": 9}):
        link = LinkNews(Health(True), clock=lambda: 0.0)
        assert len(link.lines(Health(True, lost_samples=5))) == 1
        assert len(link.lines(Health(False, lost_samples=9, **change))) == 1
        assert len(link.lines(Health(False, lost_samples=9, **change), last=True)) == 1
