"""Labels in the page's pictures never overlap and are never cut off, even for late estimates."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest
from msgspec.structs import replace as changed
from page_feed import DESCRIPTOR, LANDMARKS, Feed

from firstcontact.streaming import Estimate, Event, PageSink, PinchDone
from page_browser import needs_browser, text, until

pytestmark = needs_browser
#: The narrowest, those on both sides of the two largest changes of the page, and a wide one.
WIDTHS = (320, 640, 641, 900, 901, 1600)
#: How late an estimate is, s.
LATE = (0.0002, 0.15, 12.0)
#: Notes the box of each text that is drawn onto a canvas since it was cleared.
NOTE = """
for (const [name, noted] of [["clearRect", () => []], ["fillText", (pen, [text, x, y]) => {
  const m = pen.measureText(text);
  return [...(pen.canvas.boxes ?? []), [text, x - m.actualBoundingBoxLeft,
    y - m.actualBoundingBoxAscent, x + m.actualBoundingBoxRight, y + m.actualBoundingBoxDescent]];
}]]) {
  const own = CanvasRenderingContext2D.prototype[name];
  CanvasRenderingContext2D.prototype[name] = function (...given) {
    this.canvas.boxes = noted(this, given);
    return own.apply(this, given);
  };
}
"""
#: Of each picture: its width and height, and its texts with their boxes in it.
BOXES = """
const pictures = {};
for (const id of ["bar", "scale"]) {
  const svg = document.getElementById(id), at = svg.getBoundingClientRect();
  pictures[id] = [at.width, at.height, [...svg.querySelectorAll("text")].map((text) => {
    const b = text.getBoundingClientRect(), [x, y] = [at.left, at.top];
    return [text.textContent, b.left - x, b.top - y, b.right - x, b.bottom - y];
  })];
}
for (const id of ["traces", "closeup"]) {
  const canvas = document.getElementById(id);
  pictures[id] = [canvas.clientWidth, canvas.clientHeight, canvas.boxes ?? []];
}
return pictures;
"""
Box = tuple[str, float, float, float, float]


def _slow(event: Event, compute: float) -> Event:
    """Return the event with another computing time."""
    if isinstance(event, PinchDone):
        slow = tuple(_slow_estimate(e, compute) for e in event.estimates)
        return changed(event, estimates=slow)
    return _slow_estimate(event, compute) if isinstance(event, Estimate) else event


def _slow_estimate(e: Estimate, compute: float) -> Estimate:
    return changed(e, compute=compute, available=e.available - e.compute + compute)


def next_pinch(feed: Feed, sink: PageSink, compute: float) -> str:
    """Show a pinch whose estimates take ``compute`` s. Return the last estimate's time, ms."""
    predictions = ""
    while True:
        update = feed.update()
        events = [_slow(e, compute) for e in update.events]
        sink.take(replace(update, events=tuple(events)))
        for event in events:
            if isinstance(event, Estimate):
                predictions = f"{1e3 * event.available:.2f}"
            if isinstance(event, PinchDone) and predictions:
                return predictions


def on_one_another(boxes: list[Box]) -> list[tuple[str, str]]:
    """Return the pairs of texts that overlap by more than a pixel or so."""
    return [
        (a[0], b[0])
        for i, a in enumerate(boxes)
        for b in boxes[:i]
        if min(a[3], b[3]) - max(a[1], b[1]) > 0.5 and min(a[4], b[4]) - max(a[2], b[2]) > 1.5
    ]


def cut_off(width: float, boxes: list[Box]) -> list[str]:
    return [text for text, left, _, right, _ in boxes if left < -1 or right > width + 1]


@pytest.mark.parametrize("landmarks", [LANDMARKS, {f"object {n}": 2.4 * n for n in range(41)}])
def test_no_label_lies_on_another(chromium: Any, landmarks: dict[str, float]) -> None:
    sink = PageSink(port=0, landmarks=landmarks)
    sink.open(DESCRIPTOR)
    feed = Feed()
    noting = chromium.execute_cdp_cmd("Page.addScriptToEvaluateOnNewDocument", {"source": NOTE})
    try:
        chromium.get(sink.url)
        for compute in LATE:
            predictions = next_pinch(feed, sink, compute)
            until(
                chromium,
                lambda d, t=predictions: text(d, "total").replace("\u202f", "") == f"{t} ms",
            )
            for width in WIDTHS:
                metrics = {"width": width, "height": 900, "deviceScaleFactor": 1, "mobile": False}
                chromium.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", metrics)
                # Sizes are told to the page between two frames.
                chromium.execute_async_script(
                    "const done = arguments[0];"
                    "requestAnimationFrame(() => requestAnimationFrame(() => setTimeout(done)));"
                )
                for name, (wide, _, boxes) in chromium.execute_script(BOXES).items():
                    location = f"{name}, {width} px, {compute} s: {[b[0] for b in boxes]}"
                    assert len(boxes) >= 3, location
                    assert on_one_another(boxes) == [], location
                    assert cut_off(wide, boxes) == [], location
    finally:
        chromium.execute_cdp_cmd("Page.removeScriptToEvaluateOnNewDocument", noting)
        chromium.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})
        sink.close()
