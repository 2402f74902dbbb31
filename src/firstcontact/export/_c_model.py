"""C code of a window model: its constants, and the calls of its steps in order."""

from __future__ import annotations

from importlib.resources import files

import numpy as np

from firstcontact.core import INPUT, Program
from firstcontact.export._c_text import CUnit, c_struct, constant_bytes
from firstcontact.export._trained import NamedModel
from firstcontact.models import Interval

#: Files that every window model needs, and files with the kernels of steps.
FIXED = ("fc_model",)
KERNELS = ("fc_steps", "fc_layers", "fc_shapes")

_HEADER = """\
/* {about}
   Written by `firstcontact export-model`: do not edit.

   Constants {constants} bytes, static memory {memory} bytes, nothing on a heap. */
#ifndef FC_{upper}_H
#define FC_{upper}_H

#include "fc_model.h"

#ifdef __cplusplus
extern "C" {{
#endif

enum {{ FC_{upper}_SAMPLES = {samples}, FC_{upper}_CHANNELS = {channels} }};

/* From a window of {duration:.3g} ms at {rate:g} Hz: volts from the contact,
   baseline removed. */
fc_status fc_{name}(const float *window, fc_answer *answer);

#ifdef __cplusplus
}}
#endif
#endif
"""

_SOURCE = """\
/* {about} Written by `firstcontact export-model`: do not edit. */
#include "fc_{name}.h"

#include <math.h>
#include <stddef.h>

#include "fc_flash.h"
{includes}
{constants}
{memory}static float outputs[{outputs}];

static void run(const float *window, float *out, float *spread)
{{
{calls}
}}

{model}
fc_status fc_{name}(const float *window, fc_answer *answer)
{{
    return fc_model_answer(&model, window, outputs, answer);
}}
"""


def write_model(named: NamedModel) -> CUnit:
    """Return the C code of one window model. Raise InputError if its type has no form in C."""
    spec, name = named.model.spec, named.name
    program = named.model.program()
    places, words = _places(program)
    vectors = {INPUT: "window"} | {k: f"memory + {place}" for k, place in places.items()}
    vectors[program.output] = "out"
    if program.spread is not None:
        vectors[program.spread] = "spread"
    texts, calls = [], []
    for number, step in enumerate(program.steps):
        constant_name = f"{step.kernel}_{number}"
        texts.append(c_struct(f"fc_{step.kernel}", constant_name, step.constants))
        taken = ", ".join(vectors[t] for t in step.takes)
        calls.append(f"    fc_{step.kernel}_run(&{constant_name}, {taken}, {vectors[step.gives]});")
    if program.spread is None:
        calls.append("    (void)spread;")
    used = _files(program)
    outputs = program.size(program.output)
    constants = sum(constant_bytes(step.constants) for step in program.steps)
    memory = 4 * (words + outputs)
    about = f"{named.model.kind}, {spec.task}: stiffness from one window."
    mean, scale = named.model.target
    fields = {
        "samples": spec.samples,
        "channels": spec.channels,
        "outputs": outputs,
        "run": "run",
        "mean": mean,
        "scale": scale,
        "classes": np.array(spec.classes, np.float64) if spec.classes else "NULL",
        **_interval(named.interval),
    }
    upper = name.upper()
    header = _HEADER.format(
        about=about,
        name=name,
        upper=upper,
        constants=constants,
        memory=memory,
        samples=spec.samples,
        channels=spec.channels,
        duration=1e3 * spec.duration,
        rate=spec.rate,
    )
    source = _SOURCE.format(
        about=about,
        name=name,
        includes="".join(f'#include "{kernels}.h"\n' for kernels in used),
        constants="".join(texts),
        memory=f"static float memory[{words}];\n" if words else "",
        outputs=outputs,
        calls="\n".join(calls),
        model=c_struct("fc_window_model", "model", fields),
    )
    return CUnit(
        f"fc_{name}", header, source, constants, memory, program.instructions, FIXED + used
    )


def _files(program: Program) -> tuple[str, ...]:
    """Return the names of the files that hold the kernels of a program."""
    folder = files("firstcontact.export") / "c"
    texts = {name: (folder / f"{name}.h").read_text(encoding="utf-8") for name in KERNELS}
    kernels = {step.kernel for step in program.steps}
    return tuple(
        name for name, text in texts.items() if any(f"fc_{k}_run(" in text for k in kernels)
    )


def _interval(interval: Interval | None) -> dict[str, int | float | str | np.ndarray]:
    if interval is None:
        return {"edges": -1}
    least, most = interval.limits or (0.0, 0.0)
    return {
        "edges": len(interval.edges),
        "edge": np.array(interval.edges, np.float64) if interval.edges else "NULL",
        "half_width": np.array(interval.half_widths, np.float64),
        "scaled": interval.scaled,
        "limited": interval.limits is not None,
        "least": least,
        "most": most,
    }


def _places(program: Program) -> tuple[dict[str, int], int]:
    """Return each vector's position in the shared memory, and the memory's size, in floats."""
    last = {name: k for k, step in enumerate(program.steps) for name in step.takes}
    outside = {INPUT, program.output, program.spread}
    places: dict[str, int] = {}
    lying: dict[str, tuple[int, int]] = {}
    most = 0
    for k, step in enumerate(program.steps):
        if step.gives not in outside:
            place = 0
            for start, end in sorted(lying.values()):
                if place + step.size <= start:
                    break
                place = max(place, end)
            places[step.gives] = place
            lying[step.gives] = place, place + step.size
            most = max(most, place + step.size)
        lying = {name: span for name, span in lying.items() if last.get(name, -1) > k}
    return places, most
