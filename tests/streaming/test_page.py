"""The live page in a real browser (headless Chromium)."""

import re
import threading
import time
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest
from msgspec.structs import replace
from page_feed import DESCRIPTOR, LANDMARKS, Feed, Requests

from firstcontact.device import Health
from firstcontact.streaming import ContactWithdrawn, Update
from firstcontact.streaming.events import Ask
from firstcontact.streaming.page import server
from firstcontact.streaming.page.sink import PageSink
from page_browser import needs_browser, text, until

pytestmark = needs_browser
#: Pixels of a canvas that are as blue, or as orange, as the finger they are about.
COUNT = """
const c = document.getElementById('traces'), d = c.getContext('2d');
const p = d.getImageData(0, 0, c.width, c.height).data;
let blue = 0, orange = 0;
for (let i = 0; i < p.length; i += 4) if (p[i + 3] > 200) {
  if (p[i + 2] > p[i] + 90) blue++;
  if (p[i] > p[i + 2] + 90) orange++;
}
return [blue, orange];
"""
#: Pixels of the flags above the index finger's trace, where no trace is drawn.
FLAGS_SHOWN = """
const c = document.getElementById('traces'), d = c.getContext('2d');
const p = d.getImageData(0, 11, c.width, 5).data;
let blue = 0;
for (let i = 0; i < p.length; i += 4) if (p[i + 3] > 200 && p[i + 2] > p[i] + 90) blue++;
return blue;
"""


class Fed:
    """Page whose feed has about the speed of a real hand."""

    def __init__(self, asks: tuple[Ask, ...] = (), **options: Any) -> None:
        self.feed = Feed()
        self.asked = Requests(self.feed)
        self.asked.asks = asks
        self.sink = PageSink(port=0, controls=self.asked, landmarks=LANDMARKS, **options)
        self.sink.open(DESCRIPTOR)
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._go_on)
        self._thread.start()

    def _go_on(self) -> None:
        while not self._stop.wait(0.02):
            self.sink.take(self.feed.update(99))

    def pause(self) -> None:
        self._stop.set()
        self._thread.join()

    def close(self) -> None:
        self.pause()
        self.sink.close()


@pytest.fixture
def fed() -> Iterator[Fed]:
    with closing(Fed()) as fed:
        yield fed


def faults(driver: Any) -> list[str]:
    """Return the errors in the browser's log, except lost connections and rendering warnings."""
    kinds = ("network", "rendering")
    return [e["message"] for e in driver.get_log("browser") if e["source"] not in kinds]


def test_what_happens_is_seen(fed: Fed, chromium: Any) -> None:
    chromium.get(fed.sink.url)
    until(chromium, lambda d: text(d, "value").isdigit())
    until(chromium, lambda d: len(d.find_elements("css selector", "#rows tr td b")) > 0)
    assert "simulated" in text(chromium, "source")
    assert "Nothing lost" in text(chromium, "link")
    # The next closing clears them until its estimate comes.
    until(chromium, lambda d: text(d, "interval").startswith("between "))
    sure = "correct for 90 % of touches like those in training"
    until(chromium, lambda d: text(d, "sure") == sure)
    until(chromium, lambda d: "second finger" in text(d, "verdict"))
    until(chromium, lambda d: text(d, "total").endswith(" ms"))
    for name in LANDMARKS:
        assert name in text(chromium, "scale")
    until(chromium, lambda d: "16.65 ms" in text(d, "bar"))
    until(chromium, lambda d: min(d.execute_script(COUNT)) > 200)
    until(chromium, lambda d: d.execute_script(FLAGS_SHOWN) > 20)
    until(chromium, lambda d: "1.98" in text(d, "ledger"))
    assert not faults(chromium)


def test_a_withdrawn_contact_takes_its_times_along(page: PageSink, chromium: Any) -> None:
    feed = Feed()
    while feed.sample < feed.estimate.complete + 300:
        page.take(feed.update())
    chromium.get(page.url)
    until(chromium, lambda d: text(d, "total").endswith(" ms"))
    until(chromium, lambda d: d.execute_script(FLAGS_SHOWN) > 20)
    first = feed.contacts[0]
    page.take(Update((), (ContactWithdrawn(first, first.decided + 30, 0),)))
    until(chromium, lambda d: text(d, "total") == "–")
    assert "ms" not in text(chromium, "times")
    assert "this time" not in text(chromium, "bar")
    until(chromium, lambda d: d.execute_script(FLAGS_SHOWN) == 0)
    page.take(Update((), (replace(feed.done, delay_cause="busy & slow"),), Health(True)))
    until(chromium, lambda d: "busy & slow" in text(d, "notice"))
    assert not faults(chromium)


def test_a_pinch_is_spoken_once(fed: Fed, chromium: Any) -> None:
    chromium.get(fed.sink.url)
    chromium.execute_script(
        "window.spoken = []; new MutationObserver(() => spoken.push(document.getElementById("
        "'spoken').textContent)).observe(document.getElementById('spoken'), {childList: true})"
    )
    sentences = until(chromium, lambda d: len(s := d.execute_script("return spoken")) > 2 and s)
    pattern = re.compile(r"Pinch (\d+): \d+ Shore A, between \d+ and \d+")
    numbers = [match[1] for match in map(pattern.fullmatch, sentences) if match]
    assert len(numbers) == len(sentences) == len(set(numbers))
    live = "return document.querySelectorAll('output:not([aria-live=off])').length"
    assert chromium.execute_script(live) == 0


def test_recording_and_markers_reach_the_session(fed: Fed, chromium: Any) -> None:
    chromium.get(fed.sink.url)
    record = until(chromium, lambda d: d.find_element("id", "record"))
    until(chromium, lambda d: record.is_displayed() and record.is_enabled())
    record.click()
    until(chromium, lambda d: "samples written" in text(d, "recording"))
    assert text(chromium, "record-word") == "Stop recording"
    chromium.find_element("id", "marker").send_keys("block 29 <b>\n")
    until(chromium, lambda d: "Marked “block 29 <b>”" in text(d, "recording"))
    assert chromium.execute_script("return document.getElementById('marker').value") == ""
    record.click()
    until(chromium, lambda d: text(d, "record-word") == "Start recording")
    saved = f"Recorded live-1.mcap in the folder {Path.cwd()}."
    until(chromium, lambda d: text(d, "recording") == saved)
    assert fed.asked.calls == ["record", "mark block 29 <b>", "stop"]
    fed.asked.refuses = True
    record.click()
    until(chromium, lambda d: "cannot be written to" in text(d, "recording"))
    assert text(chromium, "record-word") == "Start recording"
    assert not faults(chromium)


def test_the_hand_is_asked_by_buttons_that_are_there_where_it_can_be(chromium: Any) -> None:
    for asks, displayed in (((Ask.CLOSE, Ask.OPEN), True), ((Ask.OPEN,), False)):
        with closing(Fed(asks=asks)) as fed:
            chromium.get(fed.sink.url)
            opens = chromium.find_element("id", "open-hand")
            until(chromium, lambda d, b=opens: b.is_displayed())  # type: ignore[misc]
            closes = chromium.find_element("id", "close-hand")
            assert closes.is_displayed() is displayed
            for button in (closes, opens) if displayed else (opens,):
                button.click()
            until(chromium, lambda d, n=1 + displayed, f=fed: len(f.asked.calls) == n)  # type: ignore[misc]
            assert [call.split()[0] for call in fed.asked.calls] == ["close", "open"][
                -1 - displayed :
            ]
            assert fed.asked.calls[-1].endswith("viewer 1 of the page")
            # Whoever types may have to open it, too.
            chromium.find_element("id", "marker").send_keys("c\ue00c")
            until(chromium, lambda d, n=2 + displayed, f=fed: len(f.asked.calls) == n)  # type: ignore[misc]
            assert fed.asked.calls[-1].startswith("open")


def test_a_page_that_hangs_no_longer_holds_the_hand_closed(
    chromium: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The page must report by itself that it is alive, because the browser answers pings."""
    silence = 2.5  # a browser on a busy machine may report late
    monkeypatch.setattr(server, "SILENCE", silence)
    with closing(Fed(asks=(Ask.CLOSE, Ask.OPEN))) as fed:
        chromium.get(fed.sink.url)
        closes = chromium.find_element("id", "close-hand")
        until(chromium, lambda d: closes.is_displayed())
        closes.click()
        since = time.monotonic()
        until(chromium, lambda d: time.monotonic() - since > 2 * silence)
        assert fed.asked.gone == []
        chromium.execute_script("const end = Date.now() + 4000; while (Date.now() < end);")
        until(chromium, lambda d: fed.asked.gone)
        assert fed.asked.gone == ["viewer 1 of the page"]


def test_losses_and_a_pulled_cable_are_reported(fed: Fed, chromium: Any) -> None:
    chromium.get(fed.sink.url)
    until(chromium, lambda d: "Nothing lost" in text(d, "link"))
    fed.feed.gap(1234)
    until(chromium, lambda d: "1\u202f234 samples lost" in text(d, "link"))
    assert "bad" in str(chromium.find_element("id", "link").get_attribute("class"))
    fed.pause()
    until(chromium, lambda d: "No samples for" in text(d, "notice"))
    fed.sink.take(Update(health=Health(False, 0, 99)))
    until(chromium, lambda d: "not connected" in text(d, "notice"))
    assert not faults(chromium)


def damaged(fed: Fed) -> bool:
    """Replace the list of pinches by a number. The next pinch of the feed replaces that number."""
    fed.sink._state._put("pinches", 7)  # type: ignore[union-attr]
    return True


def test_what_fails_is_told_and_the_page_goes_on(fed: Fed, chromium: Any) -> None:
    chromium.get(fed.sink.url)
    until(chromium, lambda d: "Nothing lost" in text(d, "link"))
    fed.sink.take(Update(health=Health(True, samples=5), failed={"json": "OSError: full"}))
    until(chromium, lambda d: "json has failed: OSError: full" in text(d, "notice"))
    assert "Something failed" in text(chromium, "link")
    # A handler of the page itself that raises, too.
    until(chromium, lambda d: damaged(fed) and "cannot show pinches" in text(d, "notice"))
    until(chromium, lambda d: len(d.find_elements("css selector", "#rows tr td b")) > 0)


def test_a_server_that_is_gone_is_told_and_found_again(fed: Fed, chromium: Any) -> None:
    chromium.get(fed.sink.url)
    until(chromium, lambda d: text(d, "value").isdigit())
    port = int(fed.sink.url.split(":")[2].strip("/"))
    fed.close()
    until(chromium, lambda d: "server is gone" in text(d, "notice"))
    assert not chromium.find_element("id", "record").is_enabled()
    again = PageSink(port=port, controls=fed.asked)
    again.open(DESCRIPTOR)
    try:
        feed = Feed(1)
        for _ in range(30):
            again.take(feed.update())
        until(chromium, lambda d: "Nothing lost" in text(d, "link"))
        until(chromium, lambda d: d.find_element("id", "record").is_enabled())
    finally:
        again.close()
    assert not faults(chromium)


@pytest.mark.parametrize("token", ["a-token-of-enough-length", 'a&b#c%41 d+e?"ü;=/'])
def test_the_token_leaves_the_address_and_still_holds(chromium: Any, token: str) -> None:
    with closing(Fed(token=token)) as fed:
        bare = fed.sink.url.partition("?")[0]
        chromium.delete_all_cookies()
        chromium.get(bare)
        assert "token is missing" in chromium.find_element("css selector", "body").text
        chromium.get(fed.sink.url)
        until(chromium, lambda d: text(d, "value").isdigit())
        assert chromium.current_url == bare
        chromium.get(bare)
        until(chromium, lambda d: text(d, "value").isdigit())


@pytest.mark.parametrize("size", [(1024, 768), (768, 1024), (1600, 1000)])
def test_nothing_is_cut_off(fed: Fed, chromium: Any, size: tuple[int, int]) -> None:
    metrics = {"width": size[0], "height": size[1], "deviceScaleFactor": 1, "mobile": False}
    chromium.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", metrics)
    try:
        chromium.get(fed.sink.url)
        until(chromium, lambda d: len(d.find_elements("css selector", "#rows tr td b")) > 0)
        assert chromium.execute_script(
            "return document.documentElement.scrollWidth <= window.innerWidth"
        )
        wide = chromium.execute_script(
            "return [...document.querySelectorAll('section, header, section *')]"
            ".filter((e) => e.scrollWidth > e.clientWidth + 1 && e.clientWidth > 0)"
            ".map((e) => e.id || e.className || e.tagName)"
        )
        assert wide == []
        for name in ("record", "mark", "marker"):
            assert chromium.find_element("id", name).size["height"] >= 44
    finally:
        chromium.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})
