"""Tables of the report, made from ``results.json`` alone."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import chain

from firstcontact.core import counted, percent
from firstcontact.models import ESTIMATORS, ClassificationScores, InferenceTime, Scores, bounded
from firstcontact_lab.report import names
from firstcontact_lab.report._texts import source
from firstcontact_lab.report.results.data import DataSummary
from firstcontact_lab.report.results.stiffness import (
    InferenceTimes,
    ObjectScores,
    SplitScores,
    by_side,
)
from firstcontact_lab.report.results.study import SubjectResults


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


def shown_number(value: float, digits: int, sign: str = "") -> str:
    """A number as it is read: a minus sign, and no sign on a zero."""
    text = f"{value:{sign}.{digits}f}"
    if float(text) == 0.0:
        text = text.lstrip("+-")
    return text.replace("-", "−")


def _error(scores: Scores | None, key: str) -> Cell:
    found = bounded(scores, key)
    if found is None:
        return Cell("–")
    sign = "+" if key == "bias" else ""
    digits = 0 if key == "mse" and found.value >= 100 else 1
    ends = ", ".join(shown_number(end, digits) for end in found.ends or ())
    return Cell(shown_number(found.value, 2, sign), ends)


def _errors(scores: Scores | None, *keys: str) -> list[Cell]:
    return [_error(scores, key) for key in keys or ("rmse", "mae", "mse", "bias")]


def _accuracy(scores: Scores) -> Cell:
    found = bounded(scores, "accuracy")
    if found is None:
        return Cell("–")
    return Cell(
        percent(found.value), ", ".join(percent(e).removesuffix(" %") for e in found.ends or ())
    )


def block_table(results: SubjectResults, split: str) -> Table | None:
    """All models in one split of the blocks."""
    rows = []
    told_apart = False
    for model in names.estimators(results.blocks, True):
        its = results.blocks[model]
        scores = its.split(split)
        if scores is None:
            continue
        told_apart |= scores.accuracy is not None
        rows.append(_block_row(Cell(names.estimator(model).title), scores, names.is_floor(model)))
        aligned = its.strip_aligned.split(split) if its.strip_aligned else None
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
        + (placed if _learned(results) else ""),
    }
    head = ["", "Accuracy", "RMSE", "MAE", "MSE", "Bias"]
    if not told_apart:
        head.remove("Accuracy")
        rows = [Row([row.cells[0], *row.cells[2:]], row.floor) for row in rows]
    return Table(said[split].strip(), head, rows)


def _learned(results: SubjectResults) -> bool:
    """Whether what places the windows is a detector that learned."""
    return names.learned(results.contact.about.windows_start_at)


def _block_row(name: Cell, scores: SplitScores, floor: bool) -> Row:
    return Row([name, _accuracy(scores), *_errors(scores)], floor)


def object_table(results: SubjectResults) -> Table | None:
    """All models on unseen objects, per pinch, and the objects' means."""
    rows = []
    for model in names.estimators(results.objects, True):
        scores = results.objects[model]
        rows.append(_object_row(Cell(names.estimator(model).title), scores, names.is_floor(model)))
        if scores.strip_aligned is not None:
            name = Cell(names.estimator(model).title, "window starts at the known contact")
            rows.append(_object_row(name, scores.strip_aligned, False))
    head = ["", "RMSE", "MAE", "MSE", "Bias", "RMSE of means"]
    return (
        Table("Asked about objects that nothing was learned from; Shore A.", head, rows)
        if rows
        else None
    )


def _object_row(name: Cell, scores: ObjectScores, floor: bool) -> Row:
    means = scores.over_objects
    each = Cell(f"{means.rmse:.2f}", counted(means.n, "object"))
    return Row([name, *_errors(scores), each], floor)


def per_object_table(results: SubjectResults) -> Table | None:
    """Mean, spread and error of each object by each model but the floors."""
    models = names.estimators(results.objects)
    if not models:
        return None
    each = {m: results.objects[m].per_object for m in models}
    things = sorted(each[models[0]], key=lambda s: (each[models[0]][s].true, s))
    rows = []
    for name in things:
        first = each[models[0]][name]
        cells = [
            Cell(name.replace("_", " "), counted(first.n, "pinch")),
            Cell(f"{first.true:g}"),
        ]
        for model in models:
            o = each[model].get(name)
            if o is None:
                cells += [Cell("–"), Cell("–")]
                continue
            spread = "" if o.sd is None else f" ± {o.sd:.1f}"
            cells.append(Cell(f"{o.mean:.1f}{spread}", f"RMSE {o.rmse:.2f}"))
            cells.append(Cell(shown_number(o.bias, 1, "+")))
        rows.append(Row(cells))
    head = ["", "True"]
    for model in models:
        head += [f"{names.estimator(model).title}, mean ± SD", "bias"]
    return Table("Each object by itself; Shore A.", head, rows)


def length_table(results: SubjectResults) -> Table | None:
    """RMSE and MAE against window length."""
    lengths = results.window_length_ms
    if not lengths:
        return None
    rows = []
    (model,) = names.estimators(next(iter(lengths.values())))
    for ms in sorted(lengths, key=float):
        entry = lengths[ms][model]
        sides = (_errors(side, "rmse", "mae", "mse") for side in (entry.blocks, entry.objects))
        rows.append(Row([Cell(f"{ms} ms"), *chain(*sides)]))
    head = ["Window", "Blocks RMSE", "MAE", "MSE", "Objects RMSE", "MAE", "MSE"]
    caption = (
        f"{names.estimator(model).title} regression. Blocks by session, objects unseen; Shore A."
    )
    if results.window_length_search:
        caption += (
            f" Hyper-parameters are searched on up to {results.window_length_search.windows} "
            "windows here, on more elsewhere, so the row of 15 ms can differ from the number above."
        )
    return Table(caption, head, rows)


#: What a window holds, by its key in the results.
_WHERE = {
    "with": "the second contact is in the window",
    "without": "the second contact is not in the window",
    "misplaced": "the window does not begin at the first contact: early, late or wrong finger",
}


def second_table(results: SubjectResults) -> Table | None:
    """Error with and without the second contact in the window."""
    found = results.second_contact_in_window
    if not found:
        return None
    rows = [
        Row(
            [
                Cell(f"{side.capitalize()}, {names.estimator(model).title}", _WHERE[where]),
                *_errors(scores),
                Cell(f"{scores.n:,}"),
            ]
        )
        for model, side, where, scores in by_side(found)
    ]
    head = ["", "RMSE", "MAE", "MSE", "Bias", "Pinches"]
    return Table("The same predictions, divided; Shore A.", head, rows)


def hardness_table(results: SubjectResults) -> Table | None:
    """Rank correlations and accuracies, where only ranks are known."""
    found = results.hardness_order
    if not found:
        return None
    rows = []
    left_out = found.leave_one_material_out
    for label, small, entry in (
        ("Order, nothing learned", found.score, found.spectral_centroid),
        (
            f"Order, {names.estimator(ESTIMATORS.default).title} regression of the rank",
            "each material predicted without having been learned",
            left_out and left_out.rank_regression,
        ),
    ):
        if entry and entry.rho is not None:
            kind = "exact" if entry.exact else "sampled"
            rows.append(
                Row(
                    [
                        Cell(label, small),
                        Cell(f"ρ = {entry.rho:.2f}".replace("-", "−")),
                        Cell(f"n = {entry.n} materials", f"{kind} permutation p = {entry.p:.3f}"),
                    ]
                )
            )
    for model, scores in found.classes_left_out().items():
        rows.append(
            Row(
                [
                    Cell(f"Class, {names.estimator(model).title}", "material left out"),
                    _accuracy(scores),
                    Cell(_constant(scores), counted(scores.n, "pinch")),
                ],
                names.is_floor(model),
            )
        )
    for model, random in (found.random_folds or {}).items():
        rows.append(
            Row(
                [
                    Cell(
                        f"Class, {names.estimator(model).title}",
                        "random folds: the same materials on both sides, so it says little",
                    ),
                    _accuracy(random),
                    Cell(_constant(random), counted(random.n, "pinch")),
                ],
                True,
            )
        )
    caption = "Hardness order from the first 15 ms."
    if _learned(results):
        caption += (
            " For a material left out, the detector that places the windows has learned from that "
            "material too."
        )
    return Table(caption, ["", "Here", "Beside"], rows)


def _constant(scores: ClassificationScores) -> str:
    return f"best constant prediction {percent(scores.best_constant)}"


def _timed(found: Mapping[str, InferenceTimes]) -> list[tuple[str, InferenceTime]]:
    """Every model that was timed and its times, regression first."""
    out = [(names.estimator(m).title, time) for m, time in found.items()]
    classifiers = [(m, time.classification) for m, time in found.items()]
    return [
        *out, *((f"{names.estimator(m).title}, classification", t) for m, t in classifiers if t),
    ]  # fmt: skip


def _remarks(time: InferenceTime) -> str:
    vectors = "" if time.support_vectors is None else f"{time.support_vectors:,} support vectors"
    preempted = f"{time.preempted:,} calls preempted" if time.preempted else ""
    return "; ".join(said for said in (vectors, preempted) if said)


def _with_preempted(time: InferenceTime) -> str:
    return f"{time.p99_with_preempted:.0f} µs with all" if time.preempted else ""


def _beside(time: InferenceTime) -> list[Cell]:
    """The training library, and how much quicker the model is."""
    if time.reference is None:
        return [Cell("–"), Cell("–")]
    return [Cell(f"{time.reference_p50:.0f} µs", time.reference), Cell(f"{time.speedup:.1f} ×")]


def inference_table(results: SubjectResults) -> Table | None:
    """p50 and p99 of one window, beside the training library."""
    if not results.inference_us:
        return None
    found = _timed(results.inference_us)
    rows = [
        Row(
            [
                Cell(name, _remarks(time)),
                Cell(f"{time.p50:.1f} µs"),
                Cell(f"{time.p99:.1f} µs", _with_preempted(time)),
                *_beside(time),
            ]
        )
        for name, time in found
    ]
    calls = min(time.calls for _, time in found)
    busiest = max((time for _, time in found), key=lambda time: time.load)
    caption = (
        f"One window at a time, one thread, this machine; {calls:,} calls or more each. How much "
        "quicker is the ratio of the medians. Calls during which another process took the core are "
        f"apart. Load of the machine: {busiest.load:.1f} on {busiest.cores} cores."
    )
    return Table(caption, ["", "p50", "p99", "Reference p50", "Quicker by"], rows)


def _rate(data: DataSummary) -> str:
    recorded = f"{data.sample_rate_hz:g} Hz"
    model = data.model_rate_hz
    return recorded if model is None else f"{recorded}, resampled to {model:g} Hz"


def data_table(results: SubjectResults) -> Table | None:
    """What the data are."""
    data = results.data
    if not data:
        return None
    rows = [
        Row([Cell(label), Cell(text)])
        for label, text in (
            ("Source", source(data.source)),
            (
                "Pinches",
                f"{data.pinches:,} ({data.train_pinches:,} to learn from, "
                f"{data.test_pinches:,} of unseen objects)",
            ),
            ("Specimens", f"{data.specimens:,}"),
            ("Sessions", f"{data.sessions:,}"),
            ("Rate", _rate(data)),
        )
    ]
    missing = results.contact.about.not_found
    if missing and results.contact.about.windows_start_at != "known":
        rows.append(
            Row(
                [
                    Cell("Without a detected contact"),
                    Cell(f"{missing.pinches:,} of {missing.of:,}: no window, no estimate"),
                ]
            )
        )
    return Table("", ["", ""], rows)
