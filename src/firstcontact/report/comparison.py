"""Published beside here, with a remark that the numbers themselves decide."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import sqrt
from typing import Any

from firstcontact.report import _published as published
from firstcontact.report import names
from firstcontact.report.accepted import Accepted

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
    if share < 0.9995 or share >= 1:
        return f"{100 * share:.1f} %"
    return f"{min(100 * share, 99.999):.3f} %"


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


def compare(trees: Sequence[Tree], subjects: Sequence[str], twin: bool) -> list[Compared]:
    """Rows for what is there; a row that no subject has is left out.

    Parameters
    ----------
    trees
        What is known of each subject.
    subjects
        Names of the subjects, as they are written.
    twin
        Whether they are the twin's.
    """
    rows = [
        *_offset(trees, twin),
        *_contact(trees, subjects),
        *_answer(trees),
        *_accuracy(trees, subjects),
        *_objects(trees, subjects),
        *_inference(trees),
    ]
    return [row for row in rows if any(text != "–" for text in row.here)]


def _percents(trees: Sequence[Tree], path: str) -> list[str]:
    values = [get(tree, path) for tree in trees]
    return ["–" if v is None else percent(v) for v in values]


def _here(trees: Sequence[Tree], path: str, form: str, factor: float = 1.0) -> list[str]:
    values = [get(tree, path) for tree in trees]
    return ["–" if v is None else form.format(factor * v) for v in values]


def _offset(trees: Sequence[Tree], twin: bool) -> list[Compared]:
    source = (
        "The published value is an input of the twin, so agreement proves nothing."
        if twin
        else "Another hand or way of closing gives another distribution."
    )
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
            "The paper gives mean and SD only.",
        ),
    ]


def _contact(trees: Sequence[Tree], subjects: Sequence[str]) -> list[Compared]:
    rows = []
    accepted = Accepted.of(trees)
    after = " after its label" if accepted.early else ""
    for key, value in published.CONTACT.items():
        name, at = f"Contact, {names.detector(key).title}", f"contact.{key}"
        target = _target_remark(key, trees, subjects, accepted)
        rows += [
            Compared(
                f"{name}: 20 ms windows judged right",
                percent(value),
                _percents(trees, f"{at}.window_accuracy"),
                "The paper does not say what its accuracy counts; windows are the closest reading. "
                f"{_quiet_remark(trees, subjects, at)}".strip(),
            ),
            Compared(
                f"{name}: contact windows found",
                "–",
                _percents(trees, f"{at}.contact_windows_found"),
                "The first that holds 1 ms of the contact, at most one a pinch. Missing it costs "
                "time, not the pinch: the next may find it.",
            ),
            Compared(
                f"{name}: contact placed {accepted.placed}",
                "–",
                _percents(trees, f"{at}.pinch_success"),
                "Share of pinches. First trigger on the right finger, placing the contact "
                f"{accepted.placed_fully}, nothing before it. It is placed looking back, after "
                "the trigger.",
            ),
            Compared(
                f"{name}: and decided {accepted.decided}",
                "–",
                _percents(trees, f"{at}.decided_within_3_ms"),
                f"The stricter count: the trigger itself comes {accepted.decided_fully}.",
            ),
            Compared(
                f"{name}: median delay of the decision{after}",
                "–",
                _here(trees, f"{at}.delay_ms.median", "{:.2f} ms"),
                f"All first triggers on the right finger that are not early. {target}".strip(),
            ),
        ]
    return rows


def _quiet_remark(trees: Sequence[Tree], subjects: Sequence[str], at: str) -> str:
    """What the accuracy over windows is worth: the score of a detector that never fires."""
    said = []
    for tree, name in zip(trees, subjects, strict=True):
        windows, quiet = get(tree, f"{at}.windows"), get(tree, f"{at}.quiet_windows")
        if windows and quiet is not None:
            said.append(f"{percent(quiet / windows)} ({name})")
    if not said:
        return ""
    return (
        f"Share of quiet windows, which a detector that never fires has right: {', '.join(said)}."
    )


#: Where the numbers of a target lie in a detector's scores, and whether it is a least one.
_TARGET = {
    "windows": ("window_accuracy", True),
    "pinches": ("pinch_success", True),
    "delay": ("delay_ms.median", False),
}


def _target_remark(
    detector: str, trees: Sequence[Tree], subjects: Sequence[str], accepted: Accepted
) -> str:
    """Whether a detector's target is reached, and where, of the subjects that have been judged."""
    target = published.TARGET.get(detector)
    if accepted.early or target is None:
        return ""  # what is counted here is less strict than the target
    said = []
    for tree, name in zip(trees, subjects, strict=True):
        scores = get(tree, f"contact.{detector}")
        if scores is None:
            continue
        missed = [
            part
            for part, (path, least) in _TARGET.items()
            if (value := get(scores, path)) is None
            or (value < target[part] if least else value > target[part])
        ]
        said.append(f"{name}: not reached ({', '.join(missed)})" if missed else f"{name}: reached")
    if not said:
        return ""
    return (
        f"Target of at least {percent(target['windows'])} of windows, "
        f"{percent(target['pinches'])} of pinches placed within ±3 ms, and a median delay of at "
        f"most {target['delay']:g} ms: {'; '.join(said)}."
    )


def _answer(trees: Sequence[Tree]) -> list[Compared]:
    label = "Label of the first contact" if Accepted.of(trees).early else "First contact"
    return [
        Compared(
            f"{label} to a complete 15 ms window, median",
            "–",
            _here(trees, "answer_ms.median", "{:.2f} ms"),
            "With the look-ahead of the filters and the wait for the decision, without the "
            "estimate's arithmetic.",
        ),
        Compared(
            "Answered before the second contact",
            "–",
            _percents(trees, "answer_ms.before_second"),
            "Of all pinches with a known second contact; missed, early and wrong-finger triggers "
            "count as not answered.",
        ),
    ]


def _accuracy(trees: Sequence[Tree], subjects: Sequence[str]) -> list[Compared]:
    rows = []
    for model, value in published.ACCURACY.items():
        random, session = (f"blocks.{model}.{s}" for s in ("random_90_10", "by_session"))
        rows.append(
            Compared(
                f"Blocks, {names.estimator(model).title}: accuracy, random 90/10",
                percent(value),
                [_with_interval(t, random) for t in trees],
                _interval_remark(trees, subjects, random, value),
            )
        )
        rows.append(
            Compared(
                f"Blocks, {names.estimator(model).title}: accuracy, by session",
                "–",
                [_with_interval(t, session) for t in trees],
                "Whole sessions held out, as a new session would be.",
            )
        )
    return rows


def _with_interval(tree: Tree, path: str) -> str:
    value = get(tree, f"{path}.accuracy")
    ends = get(tree, f"{path}.intervals.accuracy")
    if value is None:
        return "–"
    low, high = (percent(end).removesuffix(" %") for end in ends) if ends else ("", "")
    return percent(value) + (f" [{low}, {high}]" if ends else "")


def _interval_remark(
    trees: Sequence[Tree], subjects: Sequence[str], path: str, value: float
) -> str:
    """Where the published value lies, for each subject that has been judged."""
    said = []
    for tree, name in zip(trees, subjects, strict=True):
        ends, n = get(tree, f"{path}.intervals.accuracy"), get(tree, f"{path}.n")
        if ends is not None:
            where = (
                "inside" if ends[0] <= value <= ends[1] else "above" if value > ends[1] else "below"
            )
            said.append(f"{where} that of {name} ({n:,} test pinches)")
    mixes = "The split does not look at sessions and specimens: they lie on both sides."
    if not said:
        return mixes
    return f"Of the 95 % intervals, the published value lies {' and '.join(said)}. {mixes}"


def _objects(trees: Sequence[Tree], subjects: Sequence[str]) -> list[Compared]:
    rows = []
    for model, value in published.OBJECT_ERROR.items():
        found = [get(tree, f"objects.{model}") for tree in trees]
        for key in ("rmse", "mae", "mse"):
            rows.append(
                Compared(
                    f"Unseen objects, {names.estimator(model).title}: {key.upper()}",
                    f"{value} “MSE”" if key == "mse" else "–",
                    _here(trees, f"objects.{model}.{key}", "{:.2f}"),
                    _error_remark(key, value, found, subjects),
                )
            )
    return rows


def _error_remark(
    key: str, value: float, found: Sequence[Tree | None], subjects: Sequence[str]
) -> str:
    if key == "mae":
        return "Shore A. Not published."
    if key == "mse":
        return (
            "Shore A squared. The paper calls its number an MSE but gives it in Shore A: "
            "which was meant cannot be told, so compare with both."
        )
    root = sqrt(value)
    said = []
    for scores, name in zip(found, subjects, strict=True):
        if scores is not None:
            here = scores["rmse"]
            verdict = "above both" if here > value else "below both" if here < root else "between"
            said.append(f"{name}: {verdict}")
    if not said:
        return "Shore A."
    return (
        f"Shore A. The published {value} would be an RMSE of {root:.2f} if it is an MSE, of "
        f"{value} if it is one already; {'; '.join(said)}."
    )


def _inference(trees: Sequence[Tree]) -> list[Compared]:
    return [
        Compared(
            f"One window, {names.estimator(model).title}: p99",
            f"{value} ms",
            _here(trees, f"inference_us.{model}.p99", "{:.3f} ms", 1e-3),
            "Other computers: not comparable. The ratio to the training library on this one is. "
            "Without calls that another process interrupted.",
        )
        for model, value in published.INFERENCE.items()
    ]
