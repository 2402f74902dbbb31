"""Write answers/fc_*_sizes.h: the array sizes of the kernels on the device.

They are the sizes of the package's default detector, any-time network and gate. Run this after you
change one of them. A model of the same sizes can be sent over the wire.
"""

from __future__ import annotations

from pathlib import Path

from firstcontact.chain import GATE_STEP
from firstcontact.contact import DETECTORS, STEPS, make_detector
from firstcontact.core import ADC_COUNTS, ADC_VOLTS, FINGERTIP_RATE, SUBCOUNTS
from firstcontact.export import DIRECTIONS, detector_sizes
from firstcontact.models import (
    BEFORE,
    BESIDE,
    HEADS,
    LEVELS,
    STAGES,
    THIN,
    moments,
    pretrained,
    quiet_samples,
)
from firstcontact.signal import BASELINE, BASELINE_GUARD, samples_in
from firstcontact.streaming import AFTER
from firstcontact.testing import closings

FOLDER = Path(__file__).parent / "answers"
PAGE = """\
/* {about} Written by write_sizes.py: do not edit. */
#ifndef FC_{upper}_SIZES_H
#define FC_{upper}_SIZES_H
{head}
enum {{
{sizes}
}};
{tail}
#endif
"""
#: The detector's constants are part of the model image, so the kernel reads them there.
JUDGE = """
#define FC_JUDGE_HEADER "fc_judge_{kernel}.h"
#define FC_CHANNELS 2
#define fc_judge_constants (*fc_judge_loaded)
"""


def detector() -> tuple[str, dict[str, int]]:
    """Return kernel and sizes of the default detector."""
    # The sizes do not depend on the training data.
    trained = make_detector(DETECTORS.default).fit(closings(24))
    kernel = trained.judgement(FINGERTIP_RATE).kernel
    return kernel, detector_sizes(trained, FINGERTIP_RATE)


def anytime() -> dict[str, int]:
    """Return the sizes of the package's network in its largest form."""
    arrays = pretrained().network.to_arrays()
    outputs = {name: len(arrays[f"{name}.bias"]) for name in THIN}
    baseline = samples_in(BEFORE, FINGERTIP_RATE)
    return {
        "FC_LISTENS": 0,
        "FC_HEARD": quiet_samples(baseline, FINGERTIP_RATE),
        "FC_LONGEST": STAGES[-1],
        "FC_BEFORE": baseline,
        "FC_BESIDE": BESIDE,
        "FC_HEADS": HEADS,
        "FC_HIDDEN": outputs["query1"],
        "FC_FOUND": outputs["query2"],
        "FC_WIDEST": max(outputs.values()) + outputs["query2"],
        "FC_DIRECTIONS": max(DIRECTIONS),
        "FC_LEVELS_MOST": LEVELS,
    }


def texts() -> dict[str, str]:
    """Return the text of each header, by name."""
    rate = FINGERTIP_RATE
    kernel, lengths = detector()
    chain = {
        "FC_GATE_STEP": samples_in(GATE_STEP, rate),
        "FC_GATE_STEPS": STEPS,
        "FC_BASELINE": samples_in(BASELINE, rate),
        "FC_GUARD": samples_in(BASELINE_GUARD, rate),
        "FC_AFTER": samples_in(AFTER, rate),
    }
    listed = ", ".join(map(str, moments(rate)))
    volt = ADC_VOLTS / (ADC_COUNTS * SUBCOUNTS)
    constants = (
        "\n/* Samples after a contact with which there is an answer. */\n"
        f"#define FC_MOMENTS {listed}\n"
        f"#define FC_VOLT {volt!r}\n#define FC_PIEZO_ZERO {ADC_COUNTS * SUBCOUNTS / 2!r}\n"
    )
    return {
        "detector": _page("detector", "The detector.", JUDGE.format(kernel=kernel), lengths),
        "anytime": _page("anytime", "The any-time network.", "", anytime()),
        "chain": _page("chain", "The gate, and the signal of a contact.", "", chain, constants),
    }


def _page(name: str, about: str, head: str, sizes: dict[str, int], tail: str = "") -> str:
    lines = ",\n".join(f"    {key} = {value}" for key, value in sizes.items())
    return PAGE.format(upper=name.upper(), about=about, head=head, sizes=lines, tail=tail)


if __name__ == "__main__":
    for name, text in texts().items():
        (FOLDER / f"fc_{name}_sizes.h").write_text(text, encoding="utf-8")
