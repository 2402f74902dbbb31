"""Train, export, build for the emulated Cortex-M7, run, and print parity, budget and accuracy.

python firmware/measure/measure.py --out FOLDER [--quick] [--cmsis SOURCES]

Twin data; what is scored was not learned from: a fifth of the sessions, and objects of role
"test". Two conditions; the models know the first, both are asked for parity. Instructions are
those of the emulator; the time that they are said to last is an assumption: 1.5 cycles each.
"""

from __future__ import annotations

import argparse
import json
import shutil
from collections.abc import Sequence
from dataclasses import asdict
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
import parity
import peers
from numpy.typing import NDArray

from firstcontact.contact import DETECTORS, Detector, make_detector
from firstcontact.core import Dataset, Serial, replacing
from firstcontact.export import (
    USUAL_DIRECTIONS,
    NamedModel,
    Trained,
    compact_forms,
    forms,
    listens,
    microseconds,
)
from firstcontact.models import (
    ESTIMATORS,
    CompactNetwork,
    InContextModel,
    Interval,
    Task,
    Touches,
    WindowModel,
    adapt_network,
    deaf,
    labelled_windows,
    make_estimator,
    moments,
    pretrained,
    touches_of,
    train_final_model,
)
from firstcontact.recording import load_dataset
from firstcontact.twin import simulate

WINDOW, LEVEL, SEED = 0.015, 0.9, 0
SETS = (("paper-rig", 31), ("everyday", 32))
#: Contacts that forms of the any-time network are asked about that are not exported by default.
FEW = 40
#: Vectors of the reduced set that is counted together with the other parts.
USUAL_VECTORS = 150
Numbers = dict[str, Any]


def made(out: Path, quick: bool) -> list[Dataset]:
    """The twin's pinches in both conditions, made where they are not there yet."""
    found = []
    blocks, objects = (24, 6) if quick else (160, 25)
    for condition, seed in SETS:
        folder = out / f"pinches-{condition}"
        if not folder.exists():
            simulate(folder, condition, blocks, objects, seed)
        found.append(load_dataset(folder))
    return found


def parts(dataset: Dataset) -> tuple[Dataset, Dataset, Dataset]:
    """What is learned from, blocks of sessions that are not, and unseen objects."""
    train = dataset.take(~dataset.test)
    sessions = np.unique(train.sessions)
    held = np.isin(train.sessions, sessions[::5])
    return train.take(~held), train.take(held), dataset.take(dataset.test)


def windows(dataset: Dataset) -> Any:
    """Labelled windows from the known contacts."""
    contacts = [p.first for p in dataset.pinches]
    return labelled_windows(dataset, contacts, WINDOW, dataset.shore_a)


def scored(model: WindowModel, interval: Interval | None, data: Any, name: str) -> Numbers:
    """Error (or share of wrong classes), interval's width and coverage."""
    values = model.predict(data.X)
    if model.spec.classes:
        return {name: float((values != data.y).mean())}
    said: Numbers = {name: rmse(values - data.y)}
    if interval is not None:
        spreads = model.spread(data.X)
        units = np.ones(len(values)) if spreads is None else spreads
        ends = np.array([interval.around(v, u) for v, u in zip(values, units, strict=True)])
        said |= {f"{name}_width": float((ends[:, 1] - ends[:, 0]).mean())}
        inside = (ends[:, 0] <= data.y) & (data.y <= ends[:, 1])
        said |= {f"{name}_coverage": float(inside.mean())}
    return said


def rmse(errors: NDArray[np.float64]) -> float:
    """Root of the mean square."""
    return float(np.sqrt(np.mean(errors**2)))


def of_windows(
    sets: list[Dataset], out: Path, quick: bool, cmsis: Path | None
) -> tuple[Numbers, NamedModel]:
    """The kernel machines, whole and reduced, and what they are compared with; one of them."""
    learn, held, objects = (windows(part) for part in parts(sets[0]))
    everything = np.concatenate([windows(dataset).X for dataset in sets])
    rows: Numbers = {}
    others: Numbers = {}
    usual: NamedModel | None = None
    for task, name in ((Task.REGRESSION, "svr"), (Task.CLASSIFICATION, "svc")):
        kept = train_final_model(learn, ESTIMATORS.default, task, SEED, LEVEL, Serial(), True)
        interval = kept.interval if task is Task.REGRESSION else None
        for form in forms(NamedModel("stiffness", kept.model, interval), learn.X, learn.sessions):
            size = form.model.notes["support_vectors"]
            cost = parity.of_model(form, everything, out / f"{name}_{size}")
            row = asdict(cost) | answer_of(ESTIMATORS.default, form.model)
            row |= scored(form.model, form.interval, held, "blocks")
            if task is Task.REGRESSION:
                row |= scored(form.model, form.interval, objects, "objects")
                usual = form if size <= USUAL_VECTORS else usual
            rows[f"{name}_{size}"] = row
        if task is Task.REGRESSION:
            model: Any = kept.model
            n = kept.model.notes["support_vectors"]
            count = peers.plain(model, everything, out / "plain", None)
            others[f"plain C, SVR of {n} vectors"] = {"instructions": count}
            others |= peers.of_cmsis(model, everything, out / "cmsis", cmsis)
    assert usual is not None
    rows |= of_others(learn, held, objects, everything, out, quick)
    return {"models": rows, "peers": others}, usual


def answer_of(name: str, model: WindowModel) -> Numbers:
    """Which estimator made it, and how many samples an answer takes."""
    spec = model.spec
    its = {"estimator": name, "task": spec.task.value}
    return its | {"samples": spec.samples, "rate_hz": spec.rate}


def of_others(
    learn: Any, held: Any, objects: Any, everything: Any, out: Path, quick: bool
) -> Numbers:
    """One model of each other estimator, as it is."""
    rows: Numbers = {}
    for name, kind in ESTIMATORS.items():
        if name == ESTIMATORS.default or not set(kind.modules) <= available(kind.modules):
            continue
        estimator = make_estimator(
            name, Task.REGRESSION, learn.rate, **(kind.quick if quick else {})
        )
        model = estimator.fit(learn.X, learn.y, learn.sessions, SEED)
        cost = parity.of_model(NamedModel("stiffness", model, None), everything, out / name)
        row = asdict(cost) | answer_of(name, model) | scored(model, None, held, "blocks")
        rows[name] = row | scored(model, None, objects, "objects")
    return rows


def available(modules: Sequence[str]) -> set[str]:
    """Which of these modules are installed."""
    return {name for name in modules if find_spec(name) is not None}


def of_touches(sets: list[Dataset], out: Path, quick: bool) -> tuple[Numbers, InContextModel]:
    """The any-time network with several numbers of directions; the usual one of them."""
    learn, held, objects = parts(sets[0])
    touches, which = _touches(learn)
    sessions = learn.sessions[which]
    whole = adapt_network(pretrained(), touches, learn.shore_a[which], sessions, SEED).model
    everything = [_touches(dataset)[0] for dataset in sets]
    rows: Numbers = {
        "anytime_whole": _running(whole, held, objects),
        "anytime_deaf": _running(deaf(whole), held, objects),
    }
    contacts = [p.first for p in learn.pinches]
    chosen = whole
    for form in compact_forms(whole, learn, contacts):
        assert isinstance(form.network, CompactNetwork)
        directions = len(form.network.thin["body1"].into.bias)
        label = f"anytime_{directions}" + "_listening" * listens(form)
        usual = label == f"anytime_{USUAL_DIRECTIONS}"
        if quick and not usual:
            continue
        chosen = form if usual else chosen
        # All moments of all contacts of the usual form; of the others, what tells their costs.
        asked = [some if usual else some.take(np.arange(FEW)) for some in everything]
        costs = [
            parity.of_anytime(form, some, out / f"{label}_{k}") for k, some in enumerate(asked)
        ]
        row = asdict(costs[0])
        row["max_abs_error"] = max(c.max_abs_error for c in costs)
        row["class_mismatches"] = sum(c.class_mismatches for c in costs)
        row["asked"] = sum(c.asked for c in costs)
        row["same_bytes"] = all(c.same_bytes for c in costs)
        row |= {"estimator": InContextModel.kind, "task": Task.REGRESSION.value}
        row |= {"samples": moments(form.rate)[0], "rate_hz": form.rate}
        rows[label] = row | _running(form, held, objects)
    return rows, chosen


def _touches(dataset: Dataset) -> tuple[Touches, NDArray[np.intp]]:
    touches, which = touches_of(dataset, [p.first for p in dataset.pinches])
    there = touches.valid >= 10
    return touches.take(there), which[there]


def _running(model: InContextModel, held: Dataset, objects: Dataset) -> Numbers:
    """Error and width of the last answer before the second contact."""
    said: Numbers = {}
    for name, dataset in (("blocks", held), ("objects", objects)):
        touches, which = _touches(dataset)
        answers, truth = model.answers(touches), dataset.shore_a[which]
        said[name] = rmse(answers.values - truth)
        said[f"{name}_width"] = float((answers.high - answers.low).mean())
        inside = (answers.low <= truth) & (truth <= answers.high)
        said[f"{name}_coverage"] = float(inside.mean())
    return said


def of_detectors(sets: list[Dataset], out: Path) -> tuple[Numbers, Detector]:
    """Every detector; the default one of them."""
    learn, _, _ = parts(sets[0])
    pinches = [p for dataset in sets for p in dataset.pinches]
    rows: Numbers = {}
    usual: Detector | None = None
    for name in DETECTORS:
        detector = make_detector(name).fit(learn)
        usual = detector if name == DETECTORS.default else usual
        cost, dearest = parity.of_detector(detector, pinches, out / f"detector-{name}")
        rows[f"detector_{name}"] = asdict(cost) | dearest
    assert usual is not None
    return rows, usual


def table(results: Numbers) -> str:
    """For people."""
    head = "| | instructions | us | flash | ram | asked | max error | mismatches | same bytes |"
    lines = [head + " blocks | inside | objects | width | inside |", "|---" * 14 + "|"]
    for name, row in results["models"].items():
        count = row.get("instructions")
        cost = ["", "", "", "", "", "", "", ""]
        if count is not None:
            cost = [f"{count:,}", f"{microseconds(count):.0f}", f"{row['flash']:,}",
                    f"{row['ram']:,}", f"{row['asked']:,}", f"{row['max_abs_error']:.4f}",
                    str(row["class_mismatches"]), "yes" if row["same_bytes"] else "NO"]  # fmt: skip
        quality = ("blocks", "blocks_coverage", "objects", "objects_width", "objects_coverage")
        cost += [f"{row[key]:.2f}" if key in row else "" for key in quality]
        lines.append(f"| {name} | {' | '.join(cost)} |")
    for name, row in results["peers"].items():
        count = row.get("instructions")
        cost = " | |" if count is None else f" {count:,} | {microseconds(count):.0f} |"
        asked = " | | | |"
        if "asked" in row:
            asked = f" {row['asked']:,} | | {row['other_sides']} | |"
        lines.append(f"| {name} |{cost} | |{asked}" + " |" * 5)
    if whole := results.get("together"):
        name = f"together: {whole['parts']}"
        lines.append(f"| {name} | | | {whole['flash']:,} | {whole['ram']:,} |" + " |" * 9)
    return "\n".join(lines)


def main() -> None:
    """See above."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--cmsis", type=Path, help="unpacked sources of the package cmsisdsp")
    told = parser.parse_args()
    sets = made(told.out, told.quick)
    built = told.out / "built"
    shutil.rmtree(built, ignore_errors=True)
    results, named = of_windows(sets, built, told.quick, told.cmsis)
    detectors, detector = of_detectors(sets, built)
    touches, anytime = of_touches(sets, built, told.quick)
    results["models"] |= detectors | touches
    results["together"] = parity.together(Trained((named,), detector, anytime), built / "together")
    results["seeds"] = dict(SETS)
    with replacing(told.out / "embedded.json") as temporary:
        temporary.write_text(json.dumps(results, indent=1) + "\n", encoding="utf-8")
    text = table(results)
    (told.out / "embedded.md").write_text(text + "\n", encoding="utf-8")
    print(text)


if __name__ == "__main__":
    main()
