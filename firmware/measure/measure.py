"""Measure exported models on the emulated Cortex-M7: parity with Python, cost and accuracy.

python firmware/measure/measure.py --out FOLDER [--quick] [--cmsis SOURCES]

All data are from the twin, in two conditions. Models are trained on the first condition; parity is
measured on both. Scores are on held-out data: a fifth of the sessions, and objects of role "test".
The emulator counts instructions. Their time is an assumption: 1.5 cycles each.
"""

from __future__ import annotations

import argparse
import json
import shutil
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
import parity
import peers
from numpy.typing import NDArray

from firstcontact.chain import Image
from firstcontact.core import Dataset
from firstcontact.core.files import replacing
from firstcontact.export.budget import forms, microseconds
from firstcontact.export.hand_image import hand_image
from firstcontact.jobs import Serial
from firstcontact.models import ESTIMATORS, Task, Touches, WindowModel, adapt
from firstcontact.models.anytime import contact_signal
from firstcontact.models.interval import Interval
from firstcontact.models.labelled_data import labelled_windows
from firstcontact.models.rig.rig_model import RigModel
from firstcontact.models.training import train_final_model
from firstcontact.models.windows.window_predictor import WindowPredictor
from firstcontact.recording import load_dataset
from firstcontact.twin import TwinStream
from firstcontact.twin.sensor import DeviceFilter
from firstcontact.twin.simulation import simulate_recordings
from firstcontact_lab.report.tables import fill, markdown_table

DOCS = Path(__file__).parents[2] / "docs"
PAGES = (DOCS / "reference/lab-notes.md", DOCS / "reference/embedded.md")

WINDOW, LEVEL, SEED = 0.015, 0.9, 0
SETS = (("paper-rig", 31), ("everyday", 32))
#: Noise of the twin's fingertips at rest, V, and samples of each stream that begins at rest.
FLOORS = (0.0018, 0.0018)
STREAM = 30 * 4936
#: Numbers of pinches whose images are measured, beside all.
PINCHES = (0, 10, 20, 40, 80)
Numbers = dict[str, Any]


def twin_sets(out: Path, quick: bool) -> list[Dataset]:
    """Return the twin's pinches in both conditions. Simulate those that are missing."""
    sets = []
    blocks, objects = (24, 6) if quick else (160, 25)
    for condition, seed in SETS:
        folder = out / f"pinches-{condition}"
        if not folder.exists():
            simulate_recordings(folder, condition, blocks, objects, seed)
        sets.append(load_dataset(folder))
    return sets


def parts(dataset: Dataset) -> tuple[Dataset, Dataset, Dataset]:
    """Return the training pinches, block pinches of held-out sessions, and unseen objects."""
    blocks = dataset.take(~dataset.test)
    sessions = np.unique(blocks.sessions)
    held_out = np.isin(blocks.sessions, sessions[::5])
    return blocks.take(~held_out), blocks.take(held_out), dataset.take(dataset.test)


def windows(dataset: Dataset) -> Any:
    """Return labelled windows that start at the known contacts."""
    contacts = [p.first for p in dataset.pinches]
    return labelled_windows(dataset, contacts, WINDOW, dataset.shore_a)


def contact_signals(sets: list[Dataset], window: WindowPredictor) -> list[NDArray[np.float64]]:
    """Return the signal of each contact from which a window model predicts."""
    after = window.lengths[0] + window.lookahead
    pinches = [(p, p.first) for dataset in sets for p in dataset.pinches]
    cut = [contact_signal(p, first, window.before, after) for p, first in pinches if first]
    return [signal for signal in cut if signal is not None]


def scored(model: WindowModel, interval: Interval | None, data: Any, name: str) -> Numbers:
    """Return the error (or the share of wrong classes), and the interval's width and coverage."""
    values = model.predict(data.X)
    if model.spec.classes:
        return {name: float((values != data.y).mean())}
    scores: Numbers = {name: rmse(values - data.y)}
    if interval is not None:
        ends = np.array([interval.around(value) for value in values])
        scores |= {f"{name}_width": float((ends[:, 1] - ends[:, 0]).mean())}
        inside = (ends[:, 0] <= data.y) & (data.y <= ends[:, 1])
        scores |= {f"{name}_coverage": float(inside.mean())}
    return scores


def rmse(errors: NDArray[np.float64]) -> float:
    """Return the root mean square."""
    return float(np.sqrt(np.mean(errors**2)))


def of_windows(sets: list[Dataset], out: Path, cmsis: Path | None) -> Numbers:
    """Measure the support vector machines, full and reduced, and their peers."""
    learn, held_out, objects = (windows(part) for part in parts(sets[0]))
    everything = np.concatenate([windows(dataset).X for dataset in sets])
    rows: Numbers = {}
    peer_rows: Numbers = {}
    for task, name in ((Task.REGRESSION, "svr"), (Task.CLASSIFICATION, "svc")):
        trained = train_final_model(learn, ESTIMATORS.default, task, SEED, LEVEL, Serial())
        interval = trained.interval if task is Task.REGRESSION else None
        window = WindowPredictor(trained.model, interval)
        signals = contact_signals(sets, window)
        for form in forms(window, learn.X, learn.sessions):
            size = form.model.notes["support_vectors"]
            cost = parity.of_svm(form, signals, out / f"{name}_{size}")
            spec = form.model.spec
            row = asdict(cost) | {"estimator": ESTIMATORS.default, "task": task.value}
            row |= {"samples": spec.samples, "rate_hz": spec.rate}
            row |= scored(form.model, form.interval, held_out, "blocks")
            if task is Task.REGRESSION:
                row |= scored(form.model, form.interval, objects, "objects")
            rows[f"{name}_{size}"] = row
        if task is Task.REGRESSION:
            model: Any = trained.model
            n = trained.model.notes["support_vectors"]
            count = peers.plain(model, everything, out / "plain", None)
            peer_rows[f"plain C, SVR of {n} vectors"] = {"instructions": count}
            peer_rows |= peers.of_cmsis(model, everything, out / "cmsis", cmsis)
    return {"models": rows, "peers": peer_rows}


def of_chain(sets: list[Dataset], out: Path) -> tuple[Numbers, Numbers]:
    """Measure the chain with the default detector and model, adapted to the blocks."""
    learn, held_out, objects = parts(sets[0])
    made = adapt(learn, seed=SEED)
    made.save(out / "adapted")
    assert made.network is not None
    model = made.network
    image = Image(hand_image(out / "adapted").data)
    layout = sets[0].layout
    streams: list[parity.Samples] = [(p.data, None) for dataset in sets for p in dataset.pinches]
    for condition, seed in SETS:
        stream = TwinStream(condition, seed=seed)
        streams.append((DeviceFilter().update(stream.read(STREAM)), FLOORS))
    rows, events = parity.of_chain(image, layout, streams, out / "chain")
    rows["chain_74"] |= {"estimator": model.kind, "task": Task.REGRESSION.value}
    rows["chain_74"] |= {"samples": Touches.all_lengths(model.rate)[0], "rate_hz": model.rate}
    rows["chain_74"] |= _running(model, held_out, objects)
    in_time: Numbers = {}
    for (condition, _), dataset in zip(SETS, sets, strict=True):
        mine, events = events[: len(dataset.pinches)], events[len(dataset.pinches) :]
        seconds = [p.second and p.second.sample - p.first_sample for p in dataset.pinches]
        in_time[condition] = parity.in_time(list(zip(mine, seconds, strict=True)), layout.rate)
    return rows, in_time


def image_sizes(learn: Dataset, out: Path) -> dict[str, int]:
    """Return the bytes of the image of a model that was adapted to so many pinches."""
    order = np.random.default_rng(SEED).permutation(len(learn))
    sizes = {}
    for count in (*PINCHES, len(learn)):
        adapt(learn.take(np.sort(order[:count])) if count else None, seed=SEED).save(out)
        sizes[str(count)] = len(hand_image(out).data)
    return sizes


def _touches(dataset: Dataset) -> tuple[Touches, NDArray[np.intp]]:
    touches, indices = Touches.cut(dataset, [p.first for p in dataset.pinches])
    long_enough = touches.valid >= 10
    return touches.take(long_enough), indices[long_enough]


def _running(model: RigModel, held_out: Dataset, objects: Dataset) -> Numbers:
    """Return error, width and coverage of the last prediction before the second contact."""
    scores: Numbers = {}
    for name, dataset in (("blocks", held_out), ("objects", objects)):
        touches, indices = _touches(dataset)
        answers, truth = model.predict_touches(touches), dataset.shore_a[indices]
        scores[name] = rmse(answers.value - truth)
        scores[f"{name}_width"] = float((answers.high - answers.low).mean())
        inside = (answers.low <= truth) & (truth <= answers.high)
        scores[f"{name}_coverage"] = float(inside.mean())
    return scores


def tables(results: Numbers) -> dict[str, str]:
    """Return the tables of costs, and of closings with an estimate in time, as Markdown."""
    quality = ("blocks", "objects")
    head = "model | instructions | µs | flash, bytes | RAM, bytes | C − Python | blocks | objects"
    costs = []
    for name, row in {**results["models"], **results["peers"]}.items():
        count = row.get("instructions")
        cells = ["", ""] if count is None else [f"{count:,}", f"{microseconds(count):.0f}"]
        cells += [f"{row[key]:,}" if key in row else "" for key in ("flash", "ram")]
        cells += [f"{row['max_abs_error']:.4f}" if "max_abs_error" in row else ""]
        costs.append([name, *cells, *(f"{row[key]:.2f}" if key in row else "" for key in quality)])
    titles = {"any": "any estimate in time", "first": "first estimate in time",
              "final": "last estimate before the second contact in time",
              "instant": "any, if computing took no time"}  # fmt: skip
    in_time = [
        [name, f"{row['closings']:,}", *(f"{100 * row[f'{key}_share']:.1f} %" for key in titles)]
        for name, row in results["in_time"].items()
    ]
    images = list(results["images"].items())
    measured = dict([images[-1]])  # of the model that ran on the emulator
    total = f"{results['models']['chain_sample']['flash']:,}"
    flash = [[n, f"{size:,}", total if n in measured else ""] for n, size in images]
    return {
        "flash": markdown_table("pinches | image, bytes | measured with the code, bytes", flash),
        "costs": markdown_table(head, costs),
        "in_time": markdown_table(f"condition | closings | {' | '.join(titles.values())}", in_time),
    }


def main() -> None:
    """Run all measurements and write their results."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, help="folder; without it, only the docs are written")
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--cmsis", type=Path, help="unpacked sources of the package cmsisdsp")
    settings = parser.parse_args()
    if settings.out is None:
        results = json.loads((DOCS / "results/embedded.json").read_text("utf-8"))
        for page in PAGES:
            page.write_text(fill(page.read_text("utf-8"), "embedded", tables(results)), "utf-8")
        return
    sets = twin_sets(settings.out, settings.quick)
    built = settings.out / "built"
    shutil.rmtree(built, ignore_errors=True)
    results = of_windows(sets, built, settings.cmsis)
    rows, results["in_time"] = of_chain(sets, built)
    results["models"] |= rows
    results["images"] = image_sizes(parts(sets[0])[0], built / "sizes")
    results["seeds"] = dict(SETS)
    with replacing(settings.out / "embedded.json") as temporary:
        temporary.write_text(json.dumps(results, indent=1) + "\n", encoding="utf-8")
    rows = {name: row for name, row in results["models"].items() if "same_bytes" in row}
    unequal = [name for name, r in rows.items() if r["class_mismatches"] or not r["same_bytes"]]
    print(*tables(results).values(), sep="\n")
    if unequal:
        raise SystemExit(f"C on this machine, on the Cortex-M7 and in Python differ: {unequal}")


if __name__ == "__main__":
    main()
