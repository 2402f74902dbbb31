"""Detector and network in C: the chain's own files, and their image as an array."""

from __future__ import annotations

from textwrap import fill

import numpy as np

from firstcontact.chain import build_image, work_memory
from firstcontact.core import FINGERTIP_RATE, InputError
from firstcontact.export._c_text import CUnit
from firstcontact.export._hand_image import IN_C
from firstcontact.export._trained import Trained

#: Vibration channels for which the memory is counted.
CHANNELS = 2

_HEADER = """\
/* Image for the chain ({parts}) at {rate:g} Hz.
   Written by `firstcontact export-model`: do not edit.

   Constants {constants} bytes. A chain of {channels} channels needs FC_MODEL_MEMORY bytes of work
   memory, and one fc_chain. Nothing on a heap. See fc_chain.h. */
#ifndef FC_MODEL_IMAGE_H
#define FC_MODEL_IMAGE_H

#include "fc_chain.h"

enum {{ FC_MODEL_BYTES = {constants}, FC_MODEL_MEMORY = {memory} }};

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

_SOURCE = """\
/* Image for the chain. Written by `firstcontact export-model`: do not edit. */
#include "fc_model_image.h"

#include "fc_flash.h"

const uint64_t fc_model_image[FC_MODEL_BYTES / 8] FC_FLASH = {{
{words}}};
"""


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
    image = build_image(rate, constants, None if network is None else network.constants())
    words = np.frombuffer(image.data, "<u8")
    numbers = fill(", ".join(f"{word:#x}u" for word in words), 100, break_long_words=False)
    parts = ", ".join(trained.parts[len(trained.models) :])
    memory = work_memory(image, CHANNELS)
    size = len(image.data)
    header = _HEADER.format(
        parts=parts, rate=rate, constants=size, memory=memory, channels=CHANNELS
    )
    source = _SOURCE.format(words=numbers)
    return CUnit("fc_model_image", header, source, size, memory, 0, (), rate)
