"""Draw the pictures of docs/explanation/beyond-blocks.md: ``python docs/draw_beyond_blocks.py``.

The first picture shows pinches that this script simulates. The others show results from
docs/results: study.json, generalise.json, whole_grasp.json. Others stay unchanged.
"""

from __future__ import annotations

import argparse
import base64
from pathlib import Path

import numpy as np

from firstcontact.core import Dataset, Label
from firstcontact.core.display import BLUE, RED, SKY
from firstcontact.models import Touches
from firstcontact.twin import (
    BLOCKS,
    CONDITIONS,
    TwinObject,
    draw_pinch,
    find_object,
    simulate_pinch,
)
from firstcontact.twin.pinch import excerpt
from firstcontact_lab.report.findings import named_subjects
from firstcontact_lab.report.style import canvas, shades, uri
from firstcontact_lab.study.page import read_study
from firstcontact_lab.study.parts.anytime import ANYTIME, anytime_figure
from firstcontact_lab.study.parts.generalise import GENERALISE, generalise_figure
from firstcontact_lab.study.parts.whole_grasp import WHOLE_GRASP, time_figure

ROOT = Path(__file__).parents[1]
IMAGES = ROOT / "docs" / "images"
#: Seeds of the hands in the first picture, and number of pinches of each object. No score uses
#: these pinches.
SEEDS, PINCHES = (611, 612, 613, 614), 40
#: Flat blocks, and round objects with about the same durometer readings.
THINGS = (
    ("block 29", SKY, "-"),
    ("apple 1", SKY, "--"),
    ("block 43", BLUE, "-"),
    ("tennis ball 1", BLUE, "--"),
    ("block 60", RED, "-"),
    ("avocado 1", RED, "--"),
)


def write(name: str, image: str) -> None:
    """Write an image from its data URI."""
    svg = base64.b64decode(image.split(",", 1)[1])
    (IMAGES / f"beyond-blocks-{name}.svg").write_bytes(svg)


def median_signal(seed: int, kind: TwinObject) -> tuple[np.ndarray, np.ndarray]:
    """Return the time (ms) and the median signal (V) of one hand's pinches of an object.

    Signal after a second contact is left out.
    """
    pinches = []
    for number in range(PINCHES):
        draw = draw_pinch(seed, CONDITIONS["everyday"], "picture", kind, f"{kind.name} {number}")
        label = Label(kind.name, kind.shore_a, None, kind.name, "picture", kind.role)
        pinches.append(simulate_pinch(excerpt(draw, 0.045), label, duration=0.065))
    touches, _ = Touches.cut(Dataset(tuple(pinches)), [pinch.first for pinch in pinches])
    samples = np.arange(touches.waves.shape[1])
    valid_waves = np.where(samples < touches.valid[:, None], touches.waves, np.nan)
    return 1e3 * samples / touches.rate, np.nanmedian(valid_waves, axis=0)


def waveforms() -> str:
    """Draw signals of one hand on flat and round objects, and of several hands on one block."""
    with canvas(1, 3, (9.6, 3.4)) as (figure, axes):
        objects, hands, levels = axes[0]
        for name, colour, style in THINGS:
            kind = find_object(name)
            title = f"{name.removesuffix(' 1')} ({kind.shore_a:g})" if style == "--" else name
            objects.plot(*median_signal(SEEDS[0], kind), style, color=colour, label=title)
        objects.legend(loc="lower left", fontsize=7, ncols=2)
        for number, seed in enumerate(SEEDS):
            signals = {block.name: median_signal(seed, block) for block in BLOCKS}
            level = np.exp(np.mean([np.log(np.max(volts)) for _, volts in signals.values()]))
            time, volts = signals[BLOCKS[3].name]
            style = {"color": shades(len(SEEDS))[number], "label": f"hand {number + 1}"}
            hands.plot(time, volts, **style)
            levels.plot(time, volts / level, **style)
        low, high = objects.get_ylim()
        objects.set(title="One hand, several things", ylabel="Piezo (V)")
        objects.set(ylim=(low - 0.25 * (high - low), high))  # room for the names
        hands.set(title=f"{BLOCKS[3].name}, several hands", ylabel="Piezo (V)")
        levels.set(title="Over the hand's own level", ylabel="Piezo / level")
        for ax in axes[0]:
            ax.set(xlabel="After contact (ms)", xlim=(0, 15))
        hands.legend(loc="upper right", fontsize=7)
        return uri(figure)


def main() -> None:
    """Draw all pictures whose results exist."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--results", type=Path, default=ROOT / "docs/results")
    folder = parser.parse_args().results
    write("waveforms", waveforms())
    for file in ("study.json", "generalise.json", "whole_grasp.json"):
        if not (folder / file).is_file():
            continue
        for name, results in named_subjects(read_study(folder / file)).items():
            anytime, generalised = results[ANYTIME], results[GENERALISE]
            grasp = results[WHOLE_GRASP]
            if anytime is not None:
                write(f"time-{name}", anytime_figure(anytime).image)
            if generalised is not None:
                write(f"errors-{name}", generalise_figure(generalised).image)
            if grasp is not None:
                write(f"grasp-{name}", time_figure(grasp).image)


if __name__ == "__main__":
    main()
