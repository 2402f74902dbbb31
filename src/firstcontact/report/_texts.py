"""What stands above the chapters: each sentence holds for these results, or is not said."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from firstcontact.contact.registry import DETECTORS
from firstcontact.report import names
from firstcontact.report.accepted import Accepted
from firstcontact.report.comparison import get
from firstcontact.stiffness.registry import ESTIMATORS

Tree = Mapping[str, Any]
Trees = Sequence[Tree]


def starts_at(trees: Trees) -> list[str]:
    """Where windows start, of the subjects that have been asked, each way once."""
    found = (get(tree, "contact.windows_start_at") for tree in trees)
    return list(dict.fromkeys(str(way) for way in found if way is not None))


def _start(way: str) -> str:
    """Where windows start, in words."""
    read = "the windows that stiffness is read from start"
    title = names.detector(way).title
    if names.learned(way):
        return (
            f"Every pinch is judged by an {title} detector that did not learn from it, and {read} "
            "where that detector says."
        )
    if way in DETECTORS:
        return f"{read.capitalize()} where the {title} fires, which learns nothing."
    return f"No detector that learns could be trained: {read} at the known contacts."


def detector_learned(trees: Trees) -> bool:
    """Whether what places the windows has learned from pinches."""
    return any(names.learned(way) for way in starts_at(trees))


#: Where data come from, by ``data.source``: on the badge, and in the table.
_SOURCES = {
    "twin": ("Twin results", "the twin"),
    "real": ("Real recordings", "real recordings"),
    "synthetic": ("Synthetic recordings", "synthetic"),
    "unknown": ("Recordings of unknown origin", "not known: `import --source` can say it"),
}


def kind(trees: Trees) -> str:
    """Whose results these are."""
    source = get(trees[0], "data.source") if trees else None
    return "Just begun" if source is None else _SOURCES.get(source, (f"Source: {source}", ""))[0]


def source(tree: Tree) -> str:
    """Where the data come from."""
    word = str(get(tree, "data.source"))
    return _SOURCES.get(word, ("", word))[1]


def data(trees: Trees) -> str:
    """Of the data."""
    timed = any("offset_ms" in tree for tree in trees)
    return f"What was touched{', and when each finger touched it' if timed else ''}."


def contact(trees: Trees) -> str:
    """Of contact detection."""
    said = ["20 ms windows, 3 ms of them new.", *map(_start, starts_at(trees))]
    if any(names.detectors(tree.get("contact", ())) for tree in trees):
        said.append(
            "Where a contact is placed and when that is decided are two things, because a "
            "detector looks back from its trigger: both are scored."
        )
    return " ".join(said)


def waveforms(trees: Trees) -> str:
    """Of the responses."""
    return "The first 15 ms of vibration, of the finger that touched."


def blocks(trees: Trees) -> str:
    """Of discrimination and regression."""
    return (
        "Every number stands on its floors: the mean (or most frequent class) of what was "
        "learned, and the peak amplitude alone. Small numbers are 95 % bootstrap intervals."
    )


def objects(trees: Trees) -> str:
    """Of unseen objects, with how many there are."""
    counts = [
        scores["over_objects"]["n"]
        for tree in trees
        for name, scores in tree.get("objects", {}).items()
        if name in ESTIMATORS
    ]
    known = list(dict.fromkeys(str(n) for n in counts if n is not None))
    many = f" ({' and '.join(known)} here)" if known else ""
    return (
        f"No model has learned from these objects. Small numbers are 95 % bootstrap intervals over "
        f"whole objects{many}."
    )


def nothing(trees: Trees) -> str:
    """Of what its title says all."""
    return ""


def hardness(trees: Trees) -> str:
    """Of the order of hardness."""
    order = "whether materials come in the right order of hardness"
    if any("blocks" in tree or "objects" in tree for tree in trees):
        return f"By their ranks: {order}. Errors in Shore A stand above."
    return f"No error in Shore A can be given from these labels: only {order}."


def answer(trees: Trees) -> str:
    """Of the time to an answer."""
    place = "label of the first contact" if Accepted.of(trees).early else "first contact"
    said = f"How long after the {place} a stiffness could be told"
    if any(get(tree, "answer_ms.with_second") for tree in trees):
        return f"{said}, and in how many pinches that is before the other finger touches."
    return f"{said}."


def shared(trees: Trees) -> str:
    """What both sides of splits have in common."""
    said = []
    folds = [get(tree, "contact.folds") for tree in trees]
    if any(found and found["n"] > 1 for found in folds):
        said.append(
            "Folds of contact detection hold out sessions where those are known, and share "
            "specimens."
        )
    if detector_learned(trees) and any(
        any("leave_one_shore_out" in scores for scores in tree.get("blocks", {}).values())
        or get(tree, "hardness_order.leave_one_material_out")
        for tree in trees
    ):
        said.append(
            "The detector places the windows of a Shore A level or material that is left out, and "
            "has learned from it; only the estimator has not."
        )
    return " ".join(said)


def briefly(trees: Trees) -> str:
    """How estimators learned quickly, for a quick study."""
    found = {name for tree in trees for name in (*tree.get("blocks", ()), *tree.get("objects", ()))}
    said = [
        f"{entry.title} ({', '.join(f'{key} {value}' for key, value in entry.quick.items())})"
        for name, entry in ESTIMATORS.items()
        if name in found and entry.quick
    ]
    return f" Briefly trained: {', '.join(said)}." if said else ""
