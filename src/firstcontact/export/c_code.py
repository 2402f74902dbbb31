"""Generated C code: numbers, support vector machines, and the image of the chain."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import isfinite, isnan
from textwrap import fill
from typing import Any

import numpy as np
from numpy.typing import NDArray

from firstcontact.chain import build_image
from firstcontact.chain.image import ProgramConstants, work_memory
from firstcontact.core import InputError
from firstcontact.core.layout import FINGERTIP_RATE
from firstcontact.export.budget import instructions, require_svm
from firstcontact.export.hand_image import IN_C
from firstcontact.export.parts import NamedModel, Trained
from firstcontact.models import Interval

_TYPES = {"f4": "float", "f8": "double"}
_NOTE = "Written by `firstcontact export-model`: do not edit."
#: Vibration channels for which the chain's memory is counted.
CHANNELS = 2


@dataclass(frozen=True, slots=True)
class CUnit:
    """C header and source of one part of a model, with a summary for the user."""

    name: str
    header: str
    source: str
    summary: str


def literal(value: float | np.generic) -> str:
    """Return the shortest C literal that reads back as the same number."""
    if isinstance(value, (int, np.integer)):
        return str(int(value))
    if not isfinite(value):
        return "NAN" if isnan(value) else "INFINITY" if float(value) > 0 else "-INFINITY"
    text = str(value) if isinstance(value, np.float32) else repr(float(value))
    text = text if any(mark in text for mark in ".e") else text + ".0"
    return text + "f" * isinstance(value, np.float32)


def c_array(name: str, array: NDArray[Any]) -> str:
    """Return the C definition of a constant array that stays in flash memory."""
    numbers = fill(", ".join(map(literal, array.reshape(-1))), 100, break_long_words=False)
    kind = _TYPES[array.dtype.str[1:]]
    return f"static const {kind} {name}[{array.size}] FC_FLASH = {{\n{numbers}}};\n"


def write_model(named: NamedModel) -> CUnit:
    """Return the C code of a support vector machine. Raise InputError for other models."""
    model, name = require_svm(named), named.name
    spec, constants = model.spec, model.constants()
    fields = {**constants, **_interval(named.interval)}
    arrays = {field: value for field, value in fields.items() if isinstance(value, np.ndarray)}
    values = {field: field if field in arrays else literal(fields[field]) for field in fields}
    members = ", ".join(f".{field} = {value}" for field, value in values.items())
    words = sum(int(constants[key]) for key in ("vectors", "decisions", "class_count"))
    words += spec.samples * spec.channels + 1
    size, memory = sum(array.nbytes for array in arrays.values()), 4 * words
    about = f"Support vector machine ({spec.task}): stiffness from one window. {_NOTE}"
    header = f"""\
/* {about}
   Constants {size} bytes, static memory {memory} bytes, nothing on a heap. */
#ifndef FC_{name.upper()}_H
#define FC_{name.upper()}_H

#include "fc_svm.h"

#ifdef __cplusplus
extern "C" {{
#endif

enum {{ FC_{name.upper()}_SAMPLES = {spec.samples}, FC_{name.upper()}_CHANNELS = {spec.channels} }};

/* Predict from a window of {1e3 * spec.duration:.3g} ms at {spec.rate:g} Hz: see fc_svm_predict. */
fc_status fc_{name}(const float *window, fc_prediction *prediction);

#ifdef __cplusplus
}}
#endif
#endif
"""
    source = f"""\
/* {about} */
#include "fc_{name}.h"

#include <math.h>

#include "fc_flash.h"

{"".join(c_array(*item) for item in arrays.items())}
static float memory[{words}];
static const fc_svm model = {{
{fill(members, 96, initial_indent="    ", subsequent_indent="    ")}, .memory = memory}};

fc_status fc_{name}(const float *window, fc_prediction *prediction)
{{
    return fc_svm_predict(&model, window, prediction);
}}
"""
    summary = f"{size} bytes of constants, {memory} of memory, about {instructions(model)} "
    return CUnit(f"fc_{name}", header, source, f"fc_{name}: {summary}instructions")


def _interval(interval: Interval | None) -> Mapping[str, Any]:
    """Return the fields of ``fc_svm`` for an interval."""
    if interval is None:
        return {"edges": -1}
    lowest, highest = interval.limits or (-np.inf, np.inf)
    edges = {"edge": np.array(interval.edges, np.float64)} if interval.edges else {}
    widths = np.array(interval.half_widths, np.float64)
    numbers = {"half_width": widths, "lowest": lowest, "highest": highest}
    return {"edges": len(interval.edges), **edges, **numbers}


def write_chain(trained: Trained) -> CUnit:
    """Return the C code of a detector and a network for one sampling rate."""
    detector, network = trained.detector, trained.anytime
    if detector is None:
        raise InputError("the model has no detector: name a folder that `firstcontact adapt` wrote")
    rate = trained.rate or detector.rate or FINGERTIP_RATE
    constants = detector.constants(rate)
    if constants.kind not in IN_C:
        raise InputError(
            f"the detector {detector.name!r} cannot be written in C: train with the default "
            "--detector-type"
        )
    constants_of_model = None if network is None else network.constants()
    if network is not None and isinstance(constants_of_model, ProgramConstants):
        raise InputError(
            f"{network.name} predicts in Python, so it cannot be written in C: adapt with another "
            "estimator"
        )
    image = build_image(rate, constants, constants_of_model)
    size, memory = len(image.data), work_memory(image, CHANNELS)
    words = ", ".join(f"{word:#x}u" for word in np.frombuffer(image.data, "<u8"))
    parts = ", ".join(trained.parts[len(trained.models) :])
    header = f"""\
/* Image for the chain ({parts}) at {rate:g} Hz. {_NOTE}

   Constants {size} bytes. A chain of {CHANNELS} channels needs FC_MODEL_MEMORY bytes of work
   memory, and one fc_chain. Nothing on a heap. See fc_chain.h. */
#ifndef FC_MODEL_IMAGE_H
#define FC_MODEL_IMAGE_H

#include "fc_chain.h"

enum {{ FC_MODEL_BYTES = {size}, FC_MODEL_MEMORY = {memory} }};

#ifdef __cplusplus
extern "C" {{
#endif

/* Bytes for fc_image_read, as words of a little-endian machine. */
extern const uint64_t fc_model_image[FC_MODEL_BYTES / 8];

#ifdef __cplusplus
}}
#endif
#endif
"""
    source = f"""\
/* Image for the chain. {_NOTE} */
#include "fc_model_image.h"

#include "fc_flash.h"

const uint64_t fc_model_image[FC_MODEL_BYTES / 8] FC_FLASH = {{
{fill(words, 100, break_long_words=False)}}};
"""
    summary = f"{size} bytes of constants, {memory} of memory, for {rate:g} Hz"
    return CUnit("fc_model_image", header, source, f"fc_model_image: {summary}")
