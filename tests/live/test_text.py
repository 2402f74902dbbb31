"""What a person reads in the terminal."""

from __future__ import annotations

import io
from dataclasses import replace

from page_feed import Feed
from told_events import DESCRIPTOR, everything

from firstcontact.device import Health
from firstcontact.device.twin_words import lost_text, peak_text
from firstcontact.live.sink import Update
from firstcontact.live.summary import ledger_lines
from firstcontact.live.text import TextSink
from firstcontact.recording import Marker


def test_pinches_losses_and_failures_are_a_line_each() -> None:
    stream = io.StringIO()
    sink = TextSink(stream)
    sink.open(DESCRIPTOR)
    sink.take(everything())
    sink.take(Update(health=Health(True, lost_samples=7), failed={"page": "OSError: no"}))
    sink.close()
    head, lost, failed, pinch, same, hand, own = stream.getvalue().splitlines()
    assert own == (
        "  on the hand (model 0123456789abcdef): 30.5 Shore A (22 to 39) from 12 ms at 12.2 ms, "
        "the same here (1 answers)"
    )
    assert head == "twin: fw 1, piezo, 4936 Hz"
    assert lost == "link: 7 samples lost, 7 in all"
    assert failed == "page: failed (OSError: no)"
    assert pinch.startswith(
        "pinch 1: thumb first, 30.5 Shore A (22 to 39) from 12 ms at 12.1 ms, before the second "
        "contact, model of 15 ms: 29.2 Shore A (25 to 34) at "
    )
    assert same == "the same object, 2 pinches: 30.5 Shore A (22 to 39)"
    assert hand == "hand told to close, by keyboard"


def test_what_the_twin_drops_or_breaks_is_told() -> None:
    stream = io.StringIO()
    sink = TextSink(stream)
    (arrival,) = Feed().update().arrivals
    words = (Marker(7, peak_text(3.1)), Marker(7, lost_text("broken")))
    sink.take(Update(arrivals=(replace(arrival, markers=words),), health=Health(True)))
    assert stream.getvalue() == "the hand has broken it\n"


def test_a_device_that_answers_alone_has_no_estimates_to_count() -> None:
    figures = {"asked": 3, "early": 2, "standing": 1, "used": 0, "estimates": 0, "late": 0}
    said = [*ledger_lines({**figures, "overruns": 0, "blocks": 9}, 1.0, 0.1)]
    assert not any("could be used" in line for line in said)
    said = [*ledger_lines({**figures, "overruns": 0, "blocks": 9, "estimates": 1}, 1.0, 0.1)]
    assert any("0 of 1 estimates could be used" in line for line in said)
