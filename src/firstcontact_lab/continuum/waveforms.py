"""Comparison of the twin with touches that other software simulated, read from an NPZ file.

``docs/explanation/study-protocol.md`` states the format and the finger of these files.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from firstcontact.core import FileError
from firstcontact.core.files import open_regular
from firstcontact.core.physics import gent_modulus
from firstcontact.recording.untrusted import library_errors, one_of, quote
from firstcontact.twin.mechanics import FingerParameters, ObjectParameters
from firstcontact.twin.objects import block, shell_stiffness
from firstcontact.twin.pad import ON_DIMPLES, PadParameters, confinement
from firstcontact_lab.continuum.comparison import PAD_THICKNESS, WALL, Comparison, twin_touch
from firstcontact_lab.continuum.touch import INTERVAL

#: Radius, m, mass, kg, and loss factor of round objects.
ROUND = {
    "sphere": (0.037, 0.18, 0.15),
    "orange": (0.037, 0.20, 0.45),
    "avocado": (0.034, 0.19, 0.25),
    "tennis": (0.033, 0.0577, 0.15),
}
SHAPES = ("block", "wide", *ROUND)
#: Pad as one spring, N/m, and what the amplifier yields of the force through the mount, V/N.
WHOLE = PadParameters(4.5e4, 6e11, 2.2e4, 1.5)
YIELD = 0.715
LAWS, STRAINS = ("sls", "elastic"), ("small", "large", "stick")
#: Longest touch, s.
LONGEST = 0.1
#: Largest file, unpacked.
MOST_BYTES = 100_000_000
_REMEDY = "see docs/explanation/study-protocol.md"


def compare_file(path: Path) -> dict[str, Comparison]:
    """Compare the twin with each touch in an NPZ file. Return the comparisons by touch name.

    Raise FileError if the file or one of the names in it is not valid.
    """
    with library_errors(path, "an NPZ of plain arrays", _REMEDY), open_regular(path) as stream:
        archive = np.load(stream, allow_pickle=False)
        if sum(part.file_size for part in archive.zip.infolist()) > MOST_BYTES:
            raise FileError(f"{path} has more than {MOST_BYTES:,} bytes unpacked: {_REMEDY}")
        arrays = {
            name: np.asarray(archive[name], float)
            for name in archive.files
            if name.endswith(("/t", "/volts"))
        }
    names = sorted({name.rpartition("/")[0] for name in arrays})
    if not names:
        raise FileError(f"{path} has no arrays NAME/t and NAME/volts: {_REMEDY}")
    return {name: _compare(f"{path}: {quote(name)}", name, arrays) for name in names}


def _compare(origin: str, name: str, arrays: Mapping[str, np.ndarray]) -> Comparison:
    finger, target = parse_touch_name(origin, name)
    times, volts = (arrays.get(f"{name}/{key}", np.zeros(0)) for key in ("t", "volts"))
    is_right = times.ndim == 1 and times.shape == volts.shape and times.size > 1
    if not (is_right and np.isfinite(volts).all() and volts.max() > 0):
        raise FileError(f"{origin} needs t and volts of one length, and a peak: {_REMEDY}")
    if not (times[0] >= 0 and (np.diff(times) > 0).all() and times[-1] <= LONGEST):
        raise FileError(f"{origin} needs t from 0 to {LONGEST} s, ascending: {_REMEDY}")
    steps = np.arange(0.0, times[-1] + INTERVAL, INTERVAL)
    twin = np.interp(times, steps, twin_touch(target, finger, steps))
    return Comparison(times, twin, volts)


def parse_touch_name(origin: str, name: str) -> tuple[FingerParameters, ObjectParameters]:
    """Return the finger and the object of a touch, from its name ``SHAPE-SHORE-TIP-LAW-STRAIN``.

    The object relaxes as a whole contact does, because the pad in such a file relaxes like the
    object. Raise FileError for a wrong name. Its message begins with ``origin``.
    """
    parts = name.split("-")
    if len(parts) != 5 or not (parts[1].isdigit() and 0 < int(parts[1]) < 100):
        raise FileError(f"{origin} must be named SHAPE-SHORE-TIP-LAW-STRAIN: {_REMEDY}")
    shape = one_of(origin, "SHAPE", parts[0], SHAPES)
    tip = one_of(origin, "TIP", parts[2], TIPS)
    law = one_of(origin, "LAW", parts[3], LAWS)
    one_of(origin, "STRAIN", parts[4], STRAINS)
    return TIPS[tip], _target(shape, float(parts[1]), law == "elastic")


def _finger(pad: PadParameters) -> FingerParameters:
    usual = FingerParameters()
    return usual._replace(
        pad_stiffness=pad.stiffness,
        pad_stiffening=pad.stiffening,
        pad_arm_stiffness=pad.arm_stiffness,
        pad_damping=pad.damping,
        piezo_volts_per_newton=YIELD / usual.gain,
    )


TIPS = {
    "rigid": _finger(WHOLE)._replace(pad_modulus=1e15),
    "pad": _finger(WHOLE)._replace(
        pad_confinement=confinement(FingerParameters().pad_modulus, PAD_THICKNESS)
    ),
    "dimples": _finger(PadParameters().scaled(WHOLE.stiffness / ON_DIMPLES)),
}


def _target(shape: str, shore_a: float, is_elastic: bool) -> ObjectParameters:
    if shape in ROUND:
        radius, mass, loss = ROUND[shape]
        bulk = gent_modulus(shore_a) * math.pi * radius / 2
        target = ObjectParameters.solid(shore_a, mass, bulk, loss)._replace(radius=radius)
    else:
        target = block(shore_a).nominal
        area = 4 if shape == "wide" else 1
        target = target._replace(
            face_mass=area * target.face_mass,
            bulk_stiffness=area * target.bulk_stiffness,
            bulk_damping=area * target.bulk_damping,
        )
    if is_elastic:
        target = target._replace(arm_share=0.0, bulk_damping=0.0)
    if shape != "tennis":
        return target
    dent = (1 + target.arm_share) * shell_stiffness(target.modulus, target.radius, WALL)
    return target._replace(dent_stiffness=dent)
