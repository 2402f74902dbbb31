"""Network in C for one rig. The constants of the C code include the rig's data."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import InputError
from firstcontact.export._c_text import CUnit, c_array, c_struct, constant_bytes
from firstcontact.export._reach import check_reach
from firstcontact.models import (
    BEFORE,
    BESIDE,
    HEADS,
    STAGES,
    STILL,
    CompactNetwork,
    InContextModel,
    Rounded,
    ear_constants,
    quiet_samples,
)
from firstcontact.signal import samples_in

Fields = dict[str, Any]
#: Counted instructions for one analysis of the motor's pitch.
LISTENING = 381_000
#: Largest number of samples before a contact that the C code analyses for the pitch.
MOST_HEARD = 256
#: Size of the work memory of this analysis, floats.
EAR_FLOATS = 2 * 256 + 1026 + 400 + 584

_SIZES = """\
/* Sizes of the any-time network. Written by `firstcontact export-model`: do not edit.

   Constants {constants} bytes; static memory about {memory} bytes and one fc_touch of about
   {touch}. Nothing on a heap. */
#ifndef FC_ANYTIME_SIZES_H
#define FC_ANYTIME_SIZES_H

enum {{
{sizes}
}};

#endif
"""

_SOURCE = """\
/* Constants of the any-time network, conditioned on a rig.
   Written by `firstcontact export-model`: do not edit. */
#include "fc_anytime_model.h"

#include <stddef.h>

#include "fc_flash.h"

{constants}"""

MODEL_HEADER = """\
/* The any-time model. Written by `firstcontact export-model`: do not edit. */
#ifndef FC_ANYTIME_MODEL_H
#define FC_ANYTIME_MODEL_H

#include "fc_anytime.h"

#ifdef __cplusplus
extern "C" {
#endif

extern const fc_anytime fc_anytime_model;

#ifdef __cplusplus
}
#endif
#endif
"""


def write_anytime(model: InContextModel) -> tuple[CUnit, CUnit]:
    """Return two C units of the network: its constants, and the array lengths of its kernels.

    Raises
    ------
    InputError
        The network is not in its compact form.
    """
    network = model.network
    if not isinstance(network, CompactNetwork):
        raise InputError(
            "the network is too large for C: give the recordings of its rig with --data, so that "
            "the export can fit a smaller network"
        )
    check_reach(model, network)
    texts: list[str] = []
    constants = 0

    def array(name: str, values: NDArray[Any]) -> str:
        nonlocal constants
        constants += values.nbytes
        texts.append(c_array(name, values))
        return name

    def rounded_layer(name: str, layer: Rounded) -> str:
        rows, inputs = layer.integers.shape
        weight = np.pad(layer.integers, ((0, 0), (0, -inputs % 4)))
        parts: dict[str, NDArray[Any]] = {
            "weight": weight,
            "scale": layer.scale,
            "bias": layer.bias,
        }
        initialisers = [
            f".{part} = {array(f'{name}_{part}', values)}" for part, values in parts.items()
        ]
        return f"{{.outputs = {rows}, .inputs = {inputs}, {', '.join(initialisers)}}}"

    thin = {}
    for name, layer in network.thin.items():
        into, out = (
            rounded_layer(f"{name}_into", layer.into),
            rounded_layer(f"{name}_out", layer.out),
        )
        thin[name] = f"{{{into}, {out}}}"
    rigs = []
    for finger, rig in sorted(model.rigs.items(), reverse=True):
        context, rig_name = model.context(finger), f"rig{finger + 1}"
        along = np.array([network.along(context, s) for s in range(len(STAGES))], np.float32)
        parts: dict[str, NDArray[Any]] = {"along": along}
        if rig.tokens.shape[1]:
            parts |= {"keys": context.keys, "values": context.values}
        fields = [f".finger = {finger}, .levels = {rig.tokens.shape[1]}"]
        fields.append(f".level = {rig.level!r}, .sign = {rig.sign!r}")
        motor = "NULL"
        if rig.pitch is not None:
            heard: Fields = {
                "reference": rig.pitch.reference.astype(np.float32),
                "deviation": float(rig.pitch.reference.std()),
                "usual": rig.pitch.usual,
            }
            constants += constant_bytes(heard)
            texts.append(c_struct("fc_motor", f"{rig_name}_motor", heard))
            motor = f"&{rig_name}_motor"
        fields.append(f".motor = {motor}")
        fields += [f".{part} = {array(f'{rig_name}_{part}', v)}" for part, v in parts.items()]
        rigs.append(f"    {{{', '.join(fields)}}},\n")
    texts.append(f"static const fc_rig rigs[{len(rigs)}] = {{\n{''.join(rigs)}}};\n")
    mean, sd = network.scale("inputs")
    familiar = model.familiar
    plain: dict[str, NDArray[Any]] = {
        "stage": np.array(STAGES, np.int32),
        "mean": mean,
        "each": (1 / sd).astype(np.float32),
        "factor": model.factors,
        "usual": familiar.mean,
        "whitening": familiar.whitening.astype(np.float32),
        "limit": familiar.limit,
    }
    fields_of: Fields = {name: array(name, values) for name, values in plain.items()}
    weight, bias = network.answer
    answer = (
        f"{{.outputs = {len(bias)}, .inputs = {weight.shape[1]}, "
        f".weight = {array('answer_weight', weight)}, .bias = {array('answer_bias', bias)}}}"
    )
    ear = "NULL"
    if listens(model):
        heard_samples = quiet_samples(samples_in(BEFORE, model.rate), model.rate)
        if heard_samples > MOST_HEARD:
            raise InputError(
                f"at {model.rate:g} Hz the model measures the motor's pitch in {heard_samples} "
                f"samples before a contact, but the C code stores only {MOST_HEARD}: lower "
                "--budget-us, so that the export chooses a network that does not use the pitch"
            )
        hears: Fields = ear_constants(model.rate)
        constants += constant_bytes(hears)
        texts.append(c_struct("fc_ear", "ear", hears))
        ear = "&ear"
    numbers: Fields = {
        "ear": ear,
        "rigs": len(rigs),
        "shortest": model.shortest,
        "stages": len(STAGES),
        "still": STILL,
        "rig": "rigs",
    }
    texts.append(
        c_struct(
            "fc_anytime", "fc_anytime_model", {**numbers, **fields_of, **thin, "answer": answer}
        ).replace("static const fc_anytime", "const fc_anytime")
    )
    sizes = anytime_sizes(model, network)
    memory, touch = _memory(sizes)
    listed = ",\n".join(f"    {name} = {value}" for name, value in sizes.items())
    header = _SIZES.format(constants=constants, memory=memory, touch=touch, sizes=listed)
    fixed = ("fc_anytime", "fc_whole", "fc_pitch", "fc_model", "fc_steps")
    return (
        CUnit("fc_anytime_sizes", header, "", 0, memory, 0, fixed),
        CUnit(
            "fc_anytime_model",
            MODEL_HEADER,
            _SOURCE.format(constants="".join(texts)),
            constants,
            touch,
            instructions(model),
            fixed,
        ),
    )


def anytime_sizes(model: InContextModel, network: CompactNetwork) -> dict[str, int]:
    """Return the array lengths of the network's kernels, by their names in C."""
    outputs = {name: len(layer.out.bias) for name, layer in network.thin.items()}
    return {
        "FC_LISTENS": int(listens(model)),
        "FC_HEARD": quiet_samples(samples_in(BEFORE, model.rate), model.rate),
        "FC_LONGEST": STAGES[-1],
        "FC_BEFORE": samples_in(BEFORE, model.rate),
        "FC_BESIDE": BESIDE,
        "FC_HEADS": HEADS,
        "FC_HIDDEN": outputs["query1"],
        "FC_FOUND": outputs["query2"],
        "FC_WIDEST": max(outputs.values()) + outputs["query2"],
        "FC_DIRECTIONS": max(len(layer.into.bias) for layer in network.thin.values()),
        "FC_LEVELS_MOST": max(1, *(rig.tokens.shape[1] for rig in model.rigs.values())),
    }


def _memory(sizes: Mapping[str, int]) -> tuple[int, int]:
    numbers = 3 * sizes["FC_LONGEST"] + 14 + BESIDE
    floats = numbers + 1 + sizes["FC_DIRECTIONS"] + sizes["FC_HIDDEN"] + 2 * sizes["FC_FOUND"]
    floats += sizes["FC_WIDEST"]
    floats += EAR_FLOATS * sizes["FC_LISTENS"]
    return 4 * floats + 2 * (sizes["FC_WIDEST"] + numbers + 3), 12 * sizes["FC_LONGEST"] + 32


def listens(model: InContextModel) -> bool:
    """Return True if the network uses the pitch of the motor."""
    return any(rig.pitch is not None for rig in model.rigs.values())


def instructions(model: InContextModel) -> int:
    """Return the estimated number of instructions for a prediction.

    The number includes the work on each sample and the analysis of the motor's pitch.
    """
    network = model.network
    assert isinstance(network, CompactNetwork)
    ear = LISTENING * listens(model)
    weights = sum(t.into.integers.size + t.out.integers.size for t in network.thin.values())
    outputs = sum(len(t.out.bias) for t in network.thin.values())
    return int(1.9 * weights + 3.4 * network.answer[0].size) + 85 * outputs + 25_000 + ear
