"""Names in figures: any text can be drawn, without warnings."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from firstcontact.core import Contact, Finger, Label, Pinch, fingertip_layout
from firstcontact.plots import plot_pinch
from firstcontact.plots.style import MOST, figure_label

NAMES = [r"$\frac{$", "a\nb\r\tc\x00", "x" * 200, "🍎" * 50]
MORE_NAMES = [
    "$x^2$", r"\alpha", "\x1b[31mred", "苹果", "تفاح", "_hidden", "%s", "<b>", "{", "",
]  # fmt: skip


@given(st.text(st.characters(), max_size=300))
def test_figure_text_is_one_short_line_of_glyphs(name):
    text = figure_label(name)
    assert len(text) <= MOST
    assert text.isprintable()
    text.encode("utf-8")


def test_plain_names_are_unchanged():
    for name in ("block 10", "Schwamm, weich (gelb)", r"$\frac{$", "µ 60 °C"):
        assert figure_label(name) == name
    assert figure_label("苹") == "U+82F9"
    assert figure_label("\uf400") == "U+F400"  # the font has a glyph for it, and no standard does
    assert figure_label("a\n b") == "a b"
    assert figure_label("n" * 29) == "n" * 27 + "…"


@pytest.mark.parametrize(
    "name",
    [*NAMES, *(pytest.param(name, marks=pytest.mark.slow) for name in MORE_NAMES)],
    ids=ascii,
)
def test_pinch_with_any_name_is_drawn(name, tmp_path):
    layout = fingertip_layout()
    channels = tuple(replace(c, unit=name) for c in layout.channels)
    data = np.random.default_rng(0).integers(0, 30_000, (300, 16)).astype(np.int16)
    pinch = Pinch(
        data, replace(layout, channels=channels), Label(name), 0, (Contact(Finger.INDEX, 100, 100),)
    )
    plot_pinch(pinch, f"Pinch 0: {name}", tmp_path / "a.svg")
    assert (tmp_path / "a.svg").read_text(encoding="utf-8").startswith("<?xml")
