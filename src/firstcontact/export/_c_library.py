"""Exporter "c": an Arduino and PlatformIO library in C99, with an example of a main loop."""

from __future__ import annotations

from importlib.resources import files
from pathlib import Path
from textwrap import fill

import numpy as np

from firstcontact import __version__
from firstcontact.chain import build_image
from firstcontact.chain.image import work_memory
from firstcontact.core.layout import FINGERTIP_RATE
from firstcontact.export.hand_image import detector_in_c, predictor_in_c
from firstcontact.export.registry import ModelExporter
from firstcontact.models import Model

#: Vibration channels for which the chain's memory is counted.
CHANNELS = 2
_PROPERTIES = """\
name=FirstContactModel
version={version}
author=firstcontact
maintainer=firstcontact
sentence=Contact and stiffness on the hand's microcontroller.
paragraph=Written by firstcontact export-model: {parts}.
category=Sensors
url=README.md
architectures=*
includes=fc_model_image.h
"""
_HEADER = """\
/* Image for the chain ({parts}) at {rate:g} Hz.
   Written by `firstcontact export-model`: do not edit.

   Constants {size} bytes. A chain of {channels} channels needs FC_MODEL_MEMORY bytes of work
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
_SOURCE = """\
/* Image for the chain. Written by `firstcontact export-model`: do not edit. */
#include "fc_model_image.h"

#include "fc_flash.h"

const uint64_t fc_model_image[FC_MODEL_BYTES / 8] FC_FLASH = {{
{words}}};
"""


def write(model: Model, out: Path) -> list[str]:
    """Write a C99 library with the model into the empty folder ``out``.

    Return notes for the user.
    """
    detector, predictor = model.own_detector, model.default() if model.predictors else None
    rate = detector.rate or FINGERTIP_RATE if predictor is None else predictor.rate
    constants = None if predictor is None else predictor_in_c(predictor)
    image = build_image(rate, detector_in_c(detector, rate), constants)
    source = out / "src"
    source.mkdir()
    own, code = files("firstcontact.export") / "c", files("firstcontact") / "c"
    shared = [code / "wire" / f"fc_crc32.{suffix}" for suffix in "ch"]
    shared += [entry for entry in (code / "chain").iterdir() if entry.name.startswith("fc_")]
    for entry in [own / "fc_flash.h", *shared]:
        (source / entry.name).write_text(entry.read_text(encoding="utf-8"), encoding="utf-8")
    names = [f"detector: {detector.name}"]
    names += (
        [] if predictor is None else [f"predictor: {predictor.name} of {predictor.quantity.axis}"]
    )
    parts, size, memory = ", ".join(names), len(image.data), work_memory(image, CHANNELS)
    words = ", ".join(f"{word:#x}u" for word in np.frombuffer(image.data, "<u8"))
    header = _HEADER.format(parts=parts, rate=rate, size=size, memory=memory, channels=CHANNELS)
    text = _SOURCE.format(words=fill(words, 100, break_long_words=False))
    (source / "fc_model_image.h").write_text(header, encoding="utf-8")
    (source / "fc_model_image.c").write_text(text, encoding="utf-8")
    properties = _PROPERTIES.format(version=__version__, parts=parts)
    (out / "library.properties").write_text(properties, encoding="utf-8")
    for place in ("README.md", "extras/main.c", "examples/cycles/cycles.ino"):
        (out / place).parent.mkdir(parents=True, exist_ok=True)
        text = (own / Path(place).name).read_text(encoding="utf-8")
        (out / place).write_text(text, encoding="utf-8")
    return [f"{parts}: {size} bytes of constants, {memory} of memory, for {rate:g} Hz"]


C = ModelExporter("c", write)
