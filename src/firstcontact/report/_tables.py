"""Tables of the report, made from ``results.json`` alone."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from firstcontact.report import names
from firstcontact.report._texts import source
from firstcontact.report.comparison import get, percent
from firstcontact.stiffness.registry import ESTIMATORS

Tree = Mapping[str, Any]


@dataclass(frozen=True, slots=True)
class Cell:
    """A value and, in small letters below, its interval or what it is."""

    text: str
    small: str = ""


@dataclass(frozen=True, slots=True)
class Row:
    """A row; a floor is drawn quietly."""

    cells: Sequence[Cell]
    floor: bool = False


@dataclass(frozen=True, slots=True)
class Table:
    """A table with its caption."""

    caption: str
    head: Sequence[str]
    rows: Sequence[Row]


def _interval(scores: Tree, key: str, digits: int) -> str:
    ends = get(scores, f"intervals.{key}")
    if not ends:
        return ""
    return ", ".join(_number(end, digits) for end in ends)


def _number(value: float, digits: int, sign: str = "") -> str:
    """A number as it is read: a minus sign, and no sign on a zero."""
    text = f"{value:{sign}.{digits}f}"
    if float(text) == 0.0:
        text = text.lstrip("+-")
    return text.replace("-", "−")


def _error(scores: Tree, key: str) -> Cell:
    value = scores.get(key)
    if value is None:
        return Cell("–")
    sign = "+" if key == "bias" else ""
    digits = 0 if key == "mse" and value >= 100 else 1
    return Cell(_number(value, 2, sign), _interval(scores, key, digits))


def _accuracy(scores: Tree) -> Cell:
    if "accuracy" not in scores:
        return Cell("–")
    ends = get(scores, "intervals.accuracy") or ()
    return Cell(percent(scores["accuracy"]), ", ".join(percent(e).removesuffix(" %") for e in ends))


def block_table(tree: Tree, split: str) -> Table | None:
    """All models in one split of the blocks."""
    rows = []
    models = [m for m in names.estimators(ESTIMATORS, True) if get(tree, f"blocks.{m}.{split}")]
    for model in models:
        scores = tree["blocks"][model][split]
        rows.append(_block_row(Cell(names.estimator(model).title), scores, names.is_floor(model)))
        aligned = get(tree, f"blocks.{model}.strip_aligned.{split}")
        if aligned is not None:
            name = Cell(names.estimator(model).title, "window starts at the known contact")
            rows.append(_block_row(name, aligned, False))
    if not rows:
        return None
    placed = "The detector that places the windows has learned from that level too."
    said = {
        "random_90_10": "Random 90/10, as published. Sessions and specimens lie on both sides.",
        "by_session": "By session: whole sessions held out. Specimens may lie on both sides.",
        "leave_one_shore_out": "One Shore A level left out, sessions on both sides (regression). "
        + (placed if _learned(tree) else ""),
    }
    head = ["", "Accuracy", "RMSE", "MAE", "MSE", "Bias"]
    if not any("accuracy" in tree["blocks"][model][split] for model in models):
        head.remove("Accuracy")
        rows = [Row([row.cells[0], *row.cells[2:]], row.floor) for row in rows]
    return Table(said[split].strip(), head, rows)


def _learned(tree: Tree) -> bool:
    """Whether what places the windows is a detector that learned."""
    return names.learned(get(tree, "contact.windows_start_at"))


def _block_row(name: Cell, scores: Tree, floor: bool) -> Row:
    errors = [_error(scores, key) for key in ("rmse", "mae", "mse", "bias")]
    return Row([name, _accuracy(scores), *errors], floor)


def object_table(tree: Tree) -> Table | None:
    """All models on unseen objects, per pinch, and the objects' means."""
    rows = []
    for model in names.estimators(tree.get("objects", ()), True):
        scores = tree["objects"][model]
        rows.append(_object_row(Cell(names.estimator(model).title), scores, names.is_floor(model)))
        aligned = get(scores, "strip_aligned")
        if aligned is not None:
            name = Cell(names.estimator(model).title, "window starts at the known contact")
            rows.append(_object_row(name, aligned, False))
    head = ["", "RMSE", "MAE", "MSE", "Bias", "RMSE of means"]
    return (
        Table("Asked about objects that nothing was learned from; Shore A.", head, rows)
        if rows
        else None
    )


def _object_row(name: Cell, scores: Tree, floor: bool) -> Row:
    means = scores["over_objects"]
    errors = [_error(scores, key) for key in ("rmse", "mae", "mse", "bias")]
    each = Cell(f"{means['rmse']:.2f}", f"{means['n']} objects")
    return Row([name, *errors, each], floor)


def per_object_table(tree: Tree) -> Table | None:
    """Mean, spread and error of each object by each model but the floors."""
    models = names.estimators(tree.get("objects", ()))
    if not models:
        return None
    each = {m: tree["objects"][m]["per_object"] for m in models}
    things = sorted(each[models[0]], key=lambda s: (each[models[0]][s]["true"], s))
    rows = []
    for name in things:
        first = each[models[0]][name]
        cells = [Cell(name.replace("_", " "), f"{first['n']} pinches"), Cell(f"{first['true']:g}")]
        for model in models:
            o = each[model].get(name)
            if o is None:
                cells += [Cell("–"), Cell("–")]
                continue
            spread = f" ± {o['sd']:.1f}" if "sd" in o else ""
            cells.append(Cell(f"{o['mean']:.1f}{spread}", f"RMSE {o['rmse']:.2f}"))
            cells.append(Cell(_number(o["bias"], 1, "+")))
        rows.append(Row(cells))
    head = ["", "True"]
    for model in models:
        head += [f"{names.estimator(model).title}, mean ± SD", "bias"]
    return Table("Each object by itself; Shore A.", head, rows)


def length_table(tree: Tree) -> Table | None:
    """RMSE and MAE against window length."""
    lengths = get(tree, "window_length_ms")
    if not lengths:
        return None
    rows = []
    (model,) = names.estimators(next(iter(lengths.values())))
    for ms in sorted(lengths, key=float):
        entry = lengths[ms][model]
        cells = [Cell(f"{ms} ms")]
        for side in ("blocks", "objects"):
            scores = entry.get(side)
            cells += (
                [_error(scores, "rmse"), _error(scores, "mae"), _error(scores, "mse")]
                if scores
                else [Cell("–")] * 3
            )
        rows.append(Row(cells))
    head = ["Window", "Blocks RMSE", "MAE", "MSE", "Objects RMSE", "MAE", "MSE"]
    caption = (
        f"{names.estimator(model).title} regression. Blocks by session, objects unseen; Shore A."
    )
    if searched := get(tree, "window_length_search.windows"):
        caption += (
            f" Hyper-parameters are searched on up to {searched} windows here, on more "
            "elsewhere, so the row of 15 ms can differ from the number above."
        )
    return Table(caption, head, rows)


#: What a window holds, by its key in the results.
_WHERE = {
    "with": "the second contact is in the window",
    "without": "the second contact is not in the window",
    "misplaced": "the window does not begin at the first contact: early, late or wrong finger",
}


def second_table(tree: Tree) -> Table | None:
    """Error with and without the second contact in the window."""
    found = get(tree, "second_contact_in_window")
    if not found:
        return None
    rows = [
        Row(
            [
                Cell(f"{side.capitalize()}, {names.estimator(model).title}", _WHERE[where]),
                *(_error(scores, key) for key in ("rmse", "mae", "mse", "bias")),
                Cell(f"{scores['n']:,}"),
            ]
        )
        for side in ("blocks", "objects")
        for model in found
        for where, scores in found[model].get(side, {}).items()
    ]
    head = ["", "RMSE", "MAE", "MSE", "Bias", "Pinches"]
    return Table("The same predictions, divided; Shore A.", head, rows)


def hardness_table(tree: Tree) -> Table | None:
    """Rank correlations and accuracies, where only ranks are known."""
    found = get(tree, "hardness_order")
    if not found:
        return None
    rows = []
    for label, small, entry in (
        ("Order, nothing learned", found["score"], found["spectral_centroid"]),
        (
            f"Order, {names.estimator(ESTIMATORS.default).title} regression of the rank",
            "each material predicted without having been learned",
            get(found, "leave_one_material_out.rank_regression") or {},
        ),
    ):
        if "rho" in entry:
            kind = "exact" if entry["exact"] else "sampled"
            rows.append(
                Row(
                    [
                        Cell(label, small),
                        Cell(f"ρ = {entry['rho']:.2f}".replace("-", "−")),
                        Cell(
                            f"n = {entry['n']} materials",
                            f"{kind} permutation p = {entry['p']:.3f}",
                        ),
                    ]
                )
            )
    chance = f"chance {percent(found['chance'])}"
    classes = get(found, "leave_one_material_out.classification") or {}
    for model, scores in classes.items():
        rows.append(
            Row(
                [
                    Cell(f"Class, {names.estimator(model).title}", "material left out"),
                    _accuracy(scores),
                    Cell(chance, f"{scores['n']} pinches"),
                ],
                names.is_floor(model),
            )
        )
    for model, random in (get(found, "random_folds") or {}).items():
        rows.append(
            Row(
                [
                    Cell(
                        f"Class, {names.estimator(model).title}",
                        "random folds: the same materials on both sides, so it says little",
                    ),
                    _accuracy(random),
                    Cell(chance, f"{random['n']} pinches"),
                ],
                True,
            )
        )
    caption = "Hardness order from the first 15 ms."
    if _learned(tree):
        caption += (
            " For a material left out, the detector that places the windows has learned from that "
            "material too."
        )
    return Table(caption, ["", "Here", "Beside"], rows)


def timed(found: Tree) -> list[tuple[str, Tree]]:
    """Every model that was timed and its entry, regression first."""
    out = [(names.estimator(m).title, e) for m, e in found.items()]
    classifiers = ((m, e.get("classification")) for m, e in found.items())
    return out + [(f"{names.estimator(m).title}, classification", e) for m, e in classifiers if e]


def _vectors(entry: Tree) -> str:
    count = entry.get("support_vectors")
    return "" if count is None else f"{count:,} support vectors"


def _preempted(entry: Tree) -> str:
    return f"{entry['preempted']:,} calls preempted" if entry["preempted"] else ""


def _with_preempted(entry: Tree) -> str:
    return f"{entry['p99_with_preempted']:.0f} µs with all" if entry["preempted"] else ""


def _beside(entry: Tree) -> list[Cell]:
    """The training library, and how much quicker the model is."""
    if "reference" not in entry:
        return [Cell("–"), Cell("–")]
    reference = Cell(f"{entry['reference_p50']:.0f} µs", str(entry["reference"]))
    return [reference, Cell(f"{entry['speedup']:.1f} ×")]


def _load(found: Tree) -> str:
    """How busy the machine was, at most."""
    entries = [entry for _, entry in timed(found) if "load" in entry]
    if not entries:
        return ""
    busiest = max(entries, key=lambda entry: float(entry["load"]))
    return f" Load of the machine: {busiest['load']:.1f} on {busiest['cores']} cores."


def inference_table(tree: Tree) -> Table | None:
    """p50 and p99 of one window, beside the training library."""
    found = get(tree, "inference_us")
    if not found:
        return None
    rows = [
        Row(
            [
                Cell(
                    name, "; ".join(said for said in (_vectors(entry), _preempted(entry)) if said)
                ),
                Cell(f"{entry['p50']:.1f} µs"),
                Cell(f"{entry['p99']:.1f} µs", _with_preempted(entry)),
                *_beside(entry),
            ]
        )
        for name, entry in timed(found)
    ]
    calls = min(entry["calls"] for _, entry in timed(found))
    caption = (
        f"One window at a time, one thread, this machine; {calls:,} calls or more each. How much "
        "quicker is the ratio of the medians. Calls during which another process took the core are "
        f"apart.{_load(found)}"
    )
    return Table(caption, ["", "p50", "p99", "Reference p50", "Quicker by"], rows)


def _rate(data: Tree) -> str:
    recorded = f"{data['sample_rate_hz']:g} Hz"
    model = data.get("model_rate_hz")
    return recorded if model is None else f"{recorded}, resampled to {model:g} Hz"


def data_table(tree: Tree) -> Table | None:
    """What the data are."""
    data = get(tree, "data")
    if not data:
        return None
    rows = [
        Row([Cell(label), Cell(text)])
        for label, text in (
            ("Source", source(tree)),
            (
                "Pinches",
                f"{data['pinches']:,} ({data['train_pinches']:,} to learn from, "
                f"{data['test_pinches']:,} of unseen objects)",
            ),
            ("Specimens", f"{data['specimens']:,}"),
            ("Sessions", f"{data['sessions']:,}"),
            ("Rate", _rate(data)),
        )
    ]
    missing = get(tree, "contact.not_found")
    if missing and get(tree, "contact.windows_start_at") != "known":
        rows.append(
            Row(
                [
                    Cell("Without a detected contact"),
                    Cell(f"{missing['pinches']:,} of {missing['of']:,}: no window, no estimate"),
                ]
            )
        )
    return Table("", ["", ""], rows)
