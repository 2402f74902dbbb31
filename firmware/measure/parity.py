"""Parity of exported C with Python, and its cost, over all windows and contacts."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import building
import numpy as np
from numpy.typing import NDArray

from firstcontact.chain import Chain, EventKind, Flag, Image, build_image
from firstcontact.chain.image import work_memory
from firstcontact.core import (
    Block,
    Calibration,
    ChannelKind,
    Finger,
    Layout,
    VibrationCalibration,
)
from firstcontact.export.budget import microseconds
from firstcontact.models.anytime import Hints
from firstcontact.models.windows.window_predictor import WindowPredictor


@dataclass(frozen=True)
class Cost:
    """Cost of an exported part and difference from Python.

    Parameters
    ----------
    instructions
        Instructions of the most expensive prediction; of a chain, see :func:`of_chain`.
    flash, ram
        Bytes in the image of the emulated board, with 2 kB of the measuring program.
    max_abs_error
        Largest error of values and interval ends, Shore A.
    class_mismatches
        Number of classes, refusals or streams that differ from Python's.
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


def of_svm(window: WindowPredictor, signals: Sequence[NDArray[Any]], folder: Path) -> Cost:
    """Return the cost of a prediction of an SVM, including the cut of its window."""
    folder.mkdir(parents=True)
    samples, hints = window.lengths[0], Hints()
    image = build_image(window.rate, model=window.chain_constants())
    data = building.signals(image.data, signals, samples + window.lookahead)
    native, m7, flash, ram = _run(building.chain_program("windows.c", folder / "src"), data)
    got, on_m7 = building.answers(native), building.answers(m7)
    made = [window.predict(signal, samples, -1, hints) for signal in signals]
    numbers = [(math.nan,) * 3 if p is None else (p.value, p.low, p.high) for p in made]
    wanted, wrong = np.array(numbers).T, int(((got["status"] == 0) != [*map(bool, made)]).sum())
    fields = ("value", "low", "high")
    error = max(float(np.nanmax(np.abs(got[f] - e))) for f, e in zip(fields, wanted, strict=True))
    if window.classes:
        wrong += int((got["value"] != wanted[0]).sum())
    room = 4 * (samples + 1 + len(window.model.to_arrays()["vectors"]))
    return Cost(
        int(on_m7["instructions"].max()), flash + len(image.data), ram - WINDOWS_PROVIDED + room,
        error, wrong, len(signals), building.same(got, on_m7),
    )  # fmt: skip


#: Memory that windows.c provides for an image, a signal and the work, bytes.
WINDOWS_PROVIDED = (1 << 20) + (1 << 13) + (1 << 15)
#: Samples of a stream, and the noise floors of its fingers; None for one closing.
Samples = tuple[NDArray[Any], tuple[float, float] | None]
#: Memory that streams.c provides for an image and for the work of a chain, bytes.
PROVIDED = (1 << 18) + (1 << 16)
#: Samples after a contact at which the cost of an estimate is measured: 5 and 15 ms.
MEASURED = (25, 74)


def of_chain(
    image: Image,
    layout: Layout,
    data: Sequence[Samples],
    folder: Path,
) -> tuple[dict[str, dict[str, Any]], list[NDArray[np.void]]]:
    """Return the costs of the chain, and the events of each stream on the Cortex-M7.

    Costs are of a sample on average, of the costliest sample, of the first estimate of a contact,
    and of later ones. An estimate's cost includes that of its sample. Events of Python and of both
    machines must be equal.
    """
    folder.mkdir(parents=True)
    columns = (*layout.columns(ChannelKind.VIBRATION), *layout.columns(ChannelKind.FORCE))
    plain = Layout(
        tuple(replace(layout.column_channels[k], scale=1.0, offset=0.0) for k in columns),
        layout.rate,
    )
    streams, expected = [], []
    for epoch, (counts, floors) in enumerate(data):
        volts32 = layout.physical(counts, columns).astype(np.float32)
        streams.append(building.Stream([(0, epoch, volts32)], floors))
        noise = [VibrationCalibration(f, x) for f, x in zip(Finger, floors or (), strict=False)]
        chain = Chain(image, plain, Calibration(tuple(noise)) if floors else None)
        expected.append(chain.take(Block(volts32)) + chain.finish())
    program = building.chain_program("streams.c", folder / "src")
    native, m7, flash, ram = _run(program, building.streams(image.data, streams))
    records = [building.events(raw) for raw in (native, m7)]
    same = all(building.same(a, b) for a, b in zip(*map(_without_totals, records), strict=True))
    wrong = sum(
        [tuple(e)[:7] for e in events] != [tuple(r)[:7] for r in found[:-1].tolist()]
        or [np.float32(e.value) for e in events] != found["value"][:-1].tolist()
        for events, found in zip(expected, records[0], strict=True)
    )
    totals = np.array([r[-1] for r in records[1]], building.EVENT)
    every = np.concatenate([r[:-1] for r in records[1]])
    made = every[(every["kind"] == EventKind.ESTIMATED) & (every["flags"] & Flag.FINAL == 0)]
    first = [e[e["samples"] == e["samples"].min()]["instructions"].max()
             for e in (made[made["sample"] == s] for s in np.unique(made["sample"]))]  # fmt: skip
    ram += work_memory(image, len(plain.vibration_fingers)) - PROVIDED
    shared = {"flash": flash + len(image.data), "ram": ram, "max_abs_error": 0.0,
              "class_mismatches": int(wrong), "asked": len(made), "same_bytes": same}  # fmt: skip
    rows = {
        "chain_sample": {"instructions": round(totals["sample"].sum() / totals["samples"].sum())},
        "chain_costliest": {"instructions": int(totals["known"].max())},
        "chain_first": {"instructions": int(max(first))},
    }
    for samples in MEASURED:
        counts = made["instructions"][made["samples"] == samples]
        rows[f"chain_{samples}"] = {"instructions": int(counts.max())}
    return {name: row | shared for name, row in rows.items()}, _without_totals(records[1])


def in_time(closings: Sequence[tuple[NDArray[np.void], int | None]], rate: float) -> dict[str, Any]:
    """Return in how many closings an estimate was in time on the Cortex-M7, and the shares.

    The definition is that of ``benchmarks/live.py``: closings without a contact do not count, and
    an estimate is in time if it was available before the second contact, by the clock, with all
    delays. Here the second contact is the true one, the clock is that of the emulated processor,
    and the delays are computing, and waiting for earlier samples. Without a second contact every
    estimate is in time.

    Parameters
    ----------
    closings
        Events of each closing, and the sample of its second contact, or None.
    rate
        Sampling rate, Hz.

    Returns
    -------
    dict
        Number of ``closings``. Number and share of those in which ``any`` estimate was in time;
        any would be if ``instant``, without computing; the ``first`` was; the ``final`` one was,
        the last from samples before the second contact.
    """
    counts = dict.fromkeys(("any", "instant", "first", "final"), 0)
    n = 0
    for events, second in closings:
        is_first = (events["kind"] == EventKind.CONTACT_FOUND) & (events["flags"] & Flag.FIRST != 0)
        found, withdrawn = is_first.sum(), (events["kind"] == EventKind.CONTACT_WITHDRAWN).sum()
        if found == withdrawn:
            continue
        contact = events["sample"][is_first][-1]
        is_estimate = (events["kind"] == EventKind.ESTIMATED) & (events["flags"] & Flag.FINAL == 0)
        made = events[is_estimate & (events["sample"] == contact)]
        end = math.inf if second is None else second
        spent = made["waited"].astype(np.int64) + made["instructions"]
        is_early = made["known"] + spent * (1e-6 * microseconds(1) * rate) < end
        n += 1
        counts["any"] += bool(is_early.any())
        counts["instant"] += bool((made["known"] < end).any())
        counts["first"] += bool(is_early[:1].any())
        counts["final"] += bool(is_early[contact + made["samples"] <= end][-1:].any())
    return {"closings": n, **counts} | {f"{name}_share": k / n for name, k in counts.items()}


def _without_totals(records: Sequence[NDArray[np.void]]) -> list[NDArray[np.void]]:
    return [r[:-1] for r in records]


def _run(program: building.Program, data: bytes) -> tuple[bytes, bytes, int, int]:
    """Run a program on both machines. Return both outputs and the size of the image."""
    folder = program.sources.parent
    native = building.ask_native(program.native(folder / "native"), data, folder)
    image = program.m7(folder / "m7.elf")
    m7: Any = building.ask_m7(image, data, folder)
    return native, m7, *building.memory(image)
