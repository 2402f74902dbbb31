"""Detector in C: memory sizes, and learned constants."""

from __future__ import annotations

from importlib.resources import files

from firstcontact.contact import Detector, WindowDetector
from firstcontact.core import FINGERTIP_RATE, InputError
from firstcontact.export._c_model import KERNELS
from firstcontact.export._c_text import CUnit, c_struct, constant_bytes
from firstcontact.models import COMPONENTS

#: Number of channels of a pair of fingertips. A compiler option can change it.
CHANNELS = 2

_HEADER = """\
/* Sizes of the detector {name} at {rate:g} Hz, in samples.
   Written by `firstcontact export-model`: do not edit.

   Constants {constants} bytes; static memory about {memory} bytes for {channels} channels: one
   fc_detector. Nothing on a heap. */
#ifndef FC_DETECTOR_SIZES_H
#define FC_DETECTOR_SIZES_H

#define FC_JUDGE_HEADER "fc_judge_{kernel}.h"

#ifndef FC_CHANNELS
#define FC_CHANNELS {channels}
#endif

enum {{
{sizes}
}};

#endif
"""

_SOURCE = """\
/* Constants of the detector {name}. Written by `firstcontact export-model`: do not edit. */
#include <stdint.h>

#include "fc_detector_sizes.h"
#include "fc_flash.h"

#include FC_JUDGE_HEADER

{constants}"""


def write_detector(detector: Detector, rate: float | None = None) -> CUnit:
    """Return the C code of a detector for one sampling rate.

    Parameters
    ----------
    detector
        Detector that is trained or needs no training.
    rate
        Sampling rate for a detector that accepts any, Hz; by default that of a fingertip.

    Raises
    ------
    InputError
        The detector has no form that works sample by sample, as its C code must.
    """
    if not isinstance(detector, WindowDetector):
        raise InputError(
            f"the detector {detector.name!r} cannot be written in C, because it does not judge "
            "windows: train with another --detector-type"
        )
    rate = detector.rate or rate or FINGERTIP_RATE
    lengths, judgement = detector.sizes(rate), detector.judgement(rate)
    sizes = detector_sizes(detector, rate)
    constants = constant_bytes(judgement.constants)
    memory = 8 * CHANNELS * (2 * sizes["FC_RING"] + lengths.steady + 6 + judgement.doubles) + 16
    header = _HEADER.format(
        name=detector.name,
        rate=rate,
        kernel=judgement.kernel,
        channels=CHANNELS,
        constants=constants,
        memory=memory,
        sizes=",\n".join(f"    {name} = {value}" for name, value in sizes.items()),
    )
    # The classifier's own file uses these constants, so they are not static.
    text = c_struct(f"fc_{judgement.kernel}", "fc_judge_constants", judgement.constants)
    text = text.replace("static const fc_", "const fc_")
    source = _SOURCE.format(name=detector.name, constants=text)
    fixed = ("fc_detector", "fc_onset", *_judge(judgement.kernel))
    return CUnit("fc_detector_sizes", header, source, constants, memory, 0, fixed, rate)


def _judge(kernel: str) -> tuple[str, ...]:
    """Return the names of the C files of a classifier and of the kernels that it uses."""
    name = f"fc_judge_{kernel}"
    source = files("firstcontact.export") / "c" / f"{name}.c"
    text = source.read_text(encoding="utf-8") if source.is_file() else ""
    return name, *(kernel_file for kernel_file in KERNELS if f'#include "{kernel_file}.h"' in text)


#: Names of the sizes that an image requires, in the order of its CRC.
IMAGE_SIZES = (
    "FC_WINDOW", "FC_STEP", "FC_STEADY", "FC_SEARCH", "FC_RING", "FC_LOOK", "FC_LOOKS", "FC_QUIET",
    "FC_ORDER", "FC_PARTS", "FC_LONGEST", "FC_BEFORE", "FC_BESIDE", "FC_FEATURES", "FC_HEADS",
    "FC_HIDDEN", "FC_FOUND", "FC_WIDEST", "FC_COMPONENTS",
)  # fmt: skip
#: Sizes that the kernels fix: linear-prediction order, parts of a look, features of a contact.
KERNEL_SIZES = {"FC_ORDER": 12, "FC_PARTS": 5, "FC_FEATURES": 14, "FC_COMPONENTS": COMPONENTS}


def detector_sizes(detector: WindowDetector, rate: float) -> dict[str, int]:
    """Return the buffer sizes of a fitted detector by their names in C, in samples.

    ``rate`` is the sampling rate, Hz.
    """
    lengths = detector.sizes(rate)
    return {
        "FC_WINDOW": lengths.window,
        "FC_STEP": lengths.step,
        "FC_STEADY": lengths.steady,
        "FC_SEARCH": detector.reach * lengths.step,
        "FC_RING": 1 << lengths.window.bit_length(),
        **detector.judgement(rate).sizes,
    }
