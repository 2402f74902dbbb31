"""Parity of exported C with Python, and its cost, over all windows, closings and contacts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import building
import numpy as np
from numpy.typing import NDArray

from firstcontact.contact import Detector, closing_start, detect
from firstcontact.core import Pinch
from firstcontact.export import NamedModel, Trained
from firstcontact.export import _c_library as c_library
from firstcontact.models import InContextModel, Touches, moments


@dataclass(frozen=True)
class Cost:
    """Cost of an exported part and difference from Python.

    Parameters
    ----------
    instructions
        Instructions of the most expensive prediction; for a detector the mean over 3 ms.
    flash, ram
        Bytes in the image of the emulated board, with 2 kB of the measuring program.
    max_abs_error
        Largest error of values and interval ends, Shore A.
    class_mismatches
        Number of classes, refusals, flags or contacts that differ from Python's.
    asked
        Number of predictions.
    same_bytes
        True if both machines gave the same bytes.
    """

    instructions: int
    flash: int
    ram: int
    max_abs_error: float
    class_mismatches: int
    asked: int
    same_bytes: bool


def of_model(named: NamedModel, X: NDArray[np.float32], folder: Path) -> Cost:
    """Return the cost of a window model."""
    folder.mkdir(parents=True)
    c_library.write(Trained((named,)), folder)
    definitions = {
        "MODEL": f"fc_{named.name}",
        "HEADER": f'"fc_{named.name}.h"',
        "NUMBERS": str(X[0].size),
    }
    native, m7, flash, ram = _run(
        building.Program("windows.c", folder / "src", definitions), X.tobytes()
    )
    got, on_m7 = building.answers(native), building.answers(m7)
    values = named.model.predict(X)
    spreads = named.model.spread(X)
    if named.model.spec.classes:
        wrong, error = int((got["value"] != values).sum()), 0.0
    else:
        units = np.ones(len(X)) if spreads is None else spreads
        wanted = [values, values, values]
        if named.interval is not None:
            ends = [named.interval.around(v, u) for v, u in zip(values, units, strict=True)]
            wanted = [values, *np.array(ends).T]
        fields = ("value", "low", "high")[: len(wanted) if named.interval else 1]
        error = max(float(np.abs(got[f] - w).max()) for f, w in zip(fields, wanted, strict=False))
        wrong = int((got["status"] != 0).sum())
    dearest = int(on_m7["instructions"].max())
    return Cost(dearest, flash, ram, error, wrong, len(X), building.same(got, on_m7))


def of_detector(
    detector: Detector, pinches: Sequence[Pinch], folder: Path
) -> tuple[Cost, dict[str, int]]:
    """Return the cost of a detector and its largest instruction counts.

    ``steady`` is the most expensive of the three samples that compute the steady state.
    ``dearest_3ms`` is the most expensive 3 ms without these samples, ``steady_3ms`` with them.
    """
    folder.mkdir(parents=True)
    c_library.write(Trained(detector=detector), folder)
    signals, expected = [], []
    for pinch in pinches:
        start = closing_start(pinch).sample
        first = start - pinch.first_sample
        signals.append(np.ascontiguousarray(pinch.vibration()[first:], np.float64))
        fingers = pinch.layout.vibration_fingers
        expected.append(
            [(fingers.index(c.finger), c.sample - start, c.decided - start)
             for c in detect(detector, pinch, confirm=False)]
        )  # fmt: skip
    data = building.closings(signals)
    native, m7, flash, ram = _run(building.Program("closings.c", folder / "src", {}), data)
    wrong = sum(g != w for g, w in zip(building.contacts(native), expected, strict=True))
    counted = np.frombuffer(m7, building.FOUND)
    samples = sum(map(len, signals))
    mean = round(float(counted["whole"].sum()) / samples * 15)
    same = building.contacts(native) == building.contacts(m7)
    fields = {"dearest_3ms": "dearest", "steady": "steady", "steady_3ms": "around"}
    most = {name: int(counted[field].max()) for name, field in fields.items()}
    return Cost(mean, flash, ram, 0.0, wrong, len(pinches), same), most


def of_anytime(model: InContextModel, touches: Touches, folder: Path) -> Cost:
    """Return the cost of an any-time model that predicts each millisecond."""
    folder.mkdir(parents=True)
    c_library.write(Trained(anytime=model), folder)
    times = moments(model.rate)
    data = building.touches(touches.signals, touches.valid, touches.fingers, times)
    native, m7, flash, ram = _run(building.Program("touches.c", folder / "src", {}), data)
    got, on_m7 = (np.frombuffer(raw, building.RUNNING) for raw in (native, m7))
    starts = np.cumsum([0, *(sum(t <= v for t in times) for v in touches.valid)])[:-1]
    error, wrong = 0.0, int((got["status"] != 0).sum())
    for k, samples in enumerate(times):
        indices = np.flatnonzero(touches.valid >= samples)
        wanted = model.predict(touches.take(indices).until(samples))
        records = got[starts[indices] + k]
        wrong += int((records["strange"].astype(bool) != wanted.out_of_range).sum())
        pairs = (("value", wanted.value), ("low", wanted.low), ("high", wanted.high))
        error = max(error, *(float(np.abs(records[f] - w).max(initial=0.0)) for f, w in pairs))
    same = building.same(got, on_m7)
    return Cost(int(on_m7["instructions"].max()), flash, ram, error, wrong, len(got), same)


def together(trained: Trained, folder: Path) -> dict[str, Any]:
    """Return the size of one image with all parts. The model's window has one finger."""
    folder.mkdir(parents=True)
    c_library.write(trained, folder)
    (named,) = trained.models
    definitions = {
        "MODEL": f"fc_{named.name}",
        "HEADER": f'"fc_{named.name}.h"',
        "NUMBERS": str(named.model.spec.samples * named.model.spec.channels),
    }
    image = building.Program("whole.c", folder / "src", definitions).m7(folder / "m7.elf")
    flash, ram = building.memory(image)
    return {"parts": ", ".join(trained.parts), "flash": flash, "ram": ram}


def _run(program: building.Program, data: bytes) -> tuple[bytes, bytes, int, int]:
    """Run a program on both machines. Return both outputs and the size of the image."""
    folder = program.sources.parent
    native = building.ask_native(program.native(folder / "native"), data, folder)
    image = program.m7(folder / "m7.elf")
    m7: Any = building.ask_m7(image, data, folder)
    return native, m7, *building.memory(image)
