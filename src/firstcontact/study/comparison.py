"""Published beside here, with a remark that the numbers themselves decide."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import sqrt
from typing import Any

from firstcontact.study import published
from firstcontact.study.figures.style import NAMES

Tree = Mapping[str, Any]


def get(tree: Any, path: str) -> Any:
    """The value at a dotted path, None where a key is absent."""
    for key in path.split("."):
        if not isinstance(tree, Mapping) or key not in tree:
            return None
        tree = tree[key]
    return tree


def percent(share: float) -> str:
    """A share as a percentage; never rounded up to 100."""
    return f"{100 * share:.1f} %" if share >= 1 or share < 0.9995 else f"{100 * share:.3f} %"


@dataclass(frozen=True, slots=True)
class Compared:
    """A row of the table.

    Parameters
    ----------
    label
        What is compared.
    published
        As printed in the paper, "–" where it says nothing.
    here
        One text a subject, "–" where not known (yet).
    remark
        Where the two differ or cannot be compared.
    """

    label: str
    published: str
    here: Sequence[str]
    remark: str


def compare(trees: Sequence[Tree], twin: bool) -> list[Compared]:
    """Rows for what is there; a row that no subject has is left out."""
    rows = [
        *_offset(trees, twin),
        *_contact(trees),
        *_accuracy(trees),
        *_objects(trees),
        *_inference(trees),
    ]
    return [row for row in rows if any(text != "–" for text in row.here)]


def _here(trees: Sequence[Tree], path: str, form: str, factor: float = 1.0) -> list[str]:
    values = [get(tree, path) for tree in trees]
    return ["–" if v is None else form.format(factor * v) for v in values]


def _offset(trees: Sequence[Tree], twin: bool) -> list[Compared]:
    source = (
        "The published value is an input of the twin, so agreement proves nothing."
        if twin
        else "Another hand or way of closing gives another distribution."
    )
    share = get(trees[0], "offset_ms.share_below_15")
    inside = "" if share is None else "The paper does not say this; it follows from mean and SD."
    return [
        Compared(
            "First to second contact, mean",
            f"{published.OFFSET_MEAN:.2f} ms",
            _here(trees, "offset_ms.mean", "{:.2f} ms"),
            source,
        ),
        Compared(
            "First to second contact, SD",
            f"{published.OFFSET_SD:.2f} ms",
            _here(trees, "offset_ms.sd", "{:.2f} ms"),
            source,
        ),
        Compared(
            "Second contact inside the 15 ms window",
            "–",
            _here(trees, "offset_ms.share_below_15", "{:.0f} %", 100),
            inside,
        ),
    ]


def _contact(trees: Sequence[Tree]) -> list[Compared]:
    rows = []
    for key, value in (
        ("three_sigma", published.CONTACT_THREE_SIGMA),
        ("svm", published.CONTACT_SVM),
    ):
        window, pinch = f"contact.{key}.window_accuracy", f"contact.{key}.pinch_success"
        here = ["–" if get(t, window) is None else percent(get(t, window)) for t in trees]
        each = ["–" if get(t, pinch) is None else percent(get(t, pinch)) for t in trees]
        rows.append(
            Compared(
                f"Contact, {NAMES[key]}: 20 ms windows judged right",
                percent(value),
                here,
                "The paper does not say what its accuracy counts; windows are the closest reading.",
            )
        )
        rows.append(
            Compared(f"Contact, {NAMES[key]}: pinches right", "–", each, _pinch_remark(key, trees))
        )
    return rows


def _pinch_remark(key: str, trees: Sequence[Tree]) -> str:
    text = "First trigger on the right finger, within ±3 ms, nothing before it."
    if key != "svm":
        return text
    known = [
        (get(t, "contact.svm.window_accuracy"), get(t, "contact.svm.pinch_success")) for t in trees
    ]
    known = [pair for pair in known if None not in pair]
    reached = [w >= 0.999 and p >= 0.995 for w, p in known]
    if not known:
        return text
    target = "99.9 % of windows and 99.5 % of pinches"
    if all(reached):
        return f"{text} The target ({target}) is reached."
    some = " in every condition" if any(reached) else ""
    return f"{text} The target ({target}) is not reached{some}."


def _accuracy(trees: Sequence[Tree]) -> list[Compared]:
    rows = []
    for model in ("svm", "cnn"):
        value = published.ACCURACY[model]
        random, session = (f"blocks.{model}.{s}" for s in ("random_90_10", "by_session"))
        rows.append(
            Compared(
                f"Blocks, {NAMES[model]}: accuracy, random 90/10",
                percent(value),
                [_with_interval(t, random) for t in trees],
                _interval_remark(trees, random, value),
            )
        )
        rows.append(
            Compared(
                f"Blocks, {NAMES[model]}: accuracy, by session",
                "–",
                [_with_interval(t, session) for t in trees],
                "Whole sessions held out: the number to expect in a new session.",
            )
        )
    return rows


def _with_interval(tree: Tree, path: str) -> str:
    value = get(tree, f"{path}.accuracy")
    ends = get(tree, f"{path}.intervals.accuracy")
    if value is None:
        return "–"
    return percent(value) + (f" [{100 * ends[0]:.1f}, {100 * ends[1]:.1f}]" if ends else "")


def _interval_remark(trees: Sequence[Tree], path: str, value: float) -> str:
    ends = get(trees[0], f"{path}.intervals.accuracy")
    n = get(trees[0], f"{path}.n")
    mixes = "The split puts every session and specimen on both sides."
    if ends is None:
        return mixes
    where = "inside" if ends[0] <= value <= ends[1] else "above" if value > ends[1] else "below"
    return f"The published value lies {where} the 95 % interval ({n:,} test pinches). {mixes}"


def _objects(trees: Sequence[Tree]) -> list[Compared]:
    rows = []
    for model in ("svm", "cnn"):
        value = published.OBJECT_ERROR[model]
        for key in ("rmse", "mae", "mse"):
            rows.append(
                Compared(
                    f"Unseen objects, {NAMES[model]}: {key.upper()}",
                    f"{value} “MSE”" if key == "mse" else "–",
                    _here(trees, f"objects.{model}.{key}", "{:.2f}"),
                    _error_remark(key, value, get(trees[0], f"objects.{model}")),
                )
            )
    return rows


def _error_remark(key: str, value: float, scores: Tree | None) -> str:
    if key == "mae":
        return "Shore A. Not published."
    if key == "mse":
        return (
            "Shore A squared. The paper calls its number an MSE but gives it in Shore A: "
            "which was meant cannot be told, so compare with both."
        )
    if scores is None:
        return "Shore A."
    root = sqrt(value)
    here = scores["rmse"]
    verdict = (
        "larger than under either reading of the published number"
        if here > value
        else "smaller than under either reading of the published number"
        if here < root
        else "between the two readings of the published number"
    )
    return (
        f"Shore A. {value} would be an RMSE of {root:.2f} if it is an MSE, of {value} if it is "
        f"one already; here it is {verdict}."
    )


def _inference(trees: Sequence[Tree]) -> list[Compared]:
    return [
        Compared(
            f"One window, {NAMES[model]}: p99",
            f"{published.INFERENCE[model]} ms",
            _here(trees, f"inference_us.{model}.p99", "{:.3f} ms", 1e-3),
            "Other computers: not comparable. The ratio to the training library on this one is.",
        )
        for model in ("svm", "cnn")
    ]
