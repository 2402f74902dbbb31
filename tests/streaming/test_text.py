"""Terminal text for users."""

import io
from dataclasses import replace

from example_events import ANSWER, DESCRIPTOR, EVENTS, everything, timed
from example_events import pinch as pinch_of
from page_feed import Feed

from firstcontact.core import Label
from firstcontact.device import Health
from firstcontact.device.twin_words import peak_text
from firstcontact.recording import Marker, PinchMark
from firstcontact.streaming import PinchDone, Update
from firstcontact.streaming.text import TextSink, pinch_line


def test_pinches_losses_and_failures_are_a_line_each() -> None:
    stream = io.StringIO()
    sink = TextSink(stream)
    sink.open(DESCRIPTOR)
    sink.take(everything())
    sink.take(Update(health=Health(True, lost_samples=7)))
    sink.close()
    _, lost, failed, pinch, same, hand, own_values = stream.getvalue().splitlines()
    assert "7" in lost
    assert "OSError: no" in failed
    for part in ("30.5 Shore A (22 to 39)", "in time", "14.2 ms", "Apfel ä"):
        assert part in pinch
    assert "30.5" in same
    assert "keyboard" in hand
    assert "0123456789abcdef" in own_values


def test_an_estimate_that_came_after_the_second_contact_is_a_detail() -> None:
    late = timed(ANSWER, value=40.0, waited=0.01)
    line = pinch_line(pinch_of(ANSWER, late))
    assert "30.5 Shore A (22 to 39)" in line
    assert "from 12 ms at 12.1 ms, in time, 40.0 Shore A (22 to 39)" in line
    assert "from 12 ms at 22.1 ms, too late" in line
    assert line.index("30.5") < line.index("40.0")
    assert "no estimate in time" in pinch_line(pinch_of(late))


def named(*markers: Marker, marks: tuple[PinchMark, ...] = ()) -> list[str]:
    """Return labels and markers around a pinch from sample 400 to 1600."""
    stream = io.StringIO()
    sink = TextSink(stream, {"block 29": 29.0}.get)
    sink.open(DESCRIPTOR)
    (arrival,) = Feed().update().arrivals
    (finished_pinch,) = (event for event in EVENTS if isinstance(event, PinchDone))
    words = replace(arrival, markers=markers, pinches=marks)
    sink.take(Update(arrivals=(words,), events=(finished_pinch,), health=Health(True)))
    return stream.getvalue().splitlines()[1:]


def test_a_pinch_names_the_object_of_the_twin() -> None:
    (line,) = named(Marker(450, "twin: block 29"), Marker(500, peak_text(3.0)))
    assert line.endswith(", twin: block 29, 29 Shore A")
    (line,) = named(Marker(450, "twin: pear"))
    assert line.endswith(", twin: pear")
    (line,) = named(Marker(1600, "twin: block 29"))
    assert "block" not in line, "that is the next pinch"


def test_a_pinch_says_what_a_marker_or_a_label_named() -> None:
    (line,) = named(Marker(100, "my apple"))
    assert line.endswith(', marked "my apple"')
    mark = PinchMark(0, 300, 1500, 0, Label("pear", 40.0))
    (line,) = named(marks=(mark,))
    assert line.endswith(", labelled pear, 40 Shore A")
    (line,) = named(marks=(replace(mark, epoch=1),))
    assert "pear" not in line
