"""What stands above the chapters: each sentence holds for these results, or is not said."""

from __future__ import annotations

from collections.abc import Sequence

from firstcontact.contact import DETECTORS
from firstcontact.models import window_estimators
from firstcontact_lab.report import names
from firstcontact_lab.report.accepted import Accepted
from firstcontact_lab.report.results.study import SubjectResults

Found = Sequence[SubjectResults]


def starts_at(found: Found) -> list[str]:
    """Where windows start, of the subjects that have been asked, each way once."""
    ways = (results.contact.about.windows_start_at for results in found)
    return list(dict.fromkeys(way for way in ways if way is not None))


def _start(way: str) -> str:
    """Where windows start, in words."""
    read = "the windows that stiffness is read from start"
    title = names.detector(way).title
    if names.learned(way):
        return (
            f"Every pinch is judged by a detector ({title}) that did not learn from it, and {read} "
            "where that detector says."
        )
    if way in DETECTORS:
        return f"{read.capitalize()} where the {title} fires, which learns nothing."
    return f"No detector that learns could be trained: {read} at the known contacts."


def detector_learned(found: Found) -> bool:
    """Whether what places the windows has learned from pinches."""
    return any(names.learned(way) for way in starts_at(found))


#: Where data come from, by ``data.source``: on the badge, and in the table.
_SOURCES = {
    "twin": ("Twin results", "the twin"),
    "real": ("Real recordings", "real recordings"),
    "synthetic": ("Synthetic recordings", "synthetic"),
    "unknown": ("Recordings of unknown origin", "not known: `import --source` can say it"),
}


def kind(found: Found) -> str:
    """Whose results these are."""
    data = found[0].data if found else None
    if data is None:
        return "Just begun"
    return _SOURCES.get(data.source, (f"Source: {data.source}", ""))[0]


def source(word: str) -> str:
    """Where the data come from."""
    return _SOURCES.get(word, ("", word))[1]


def data(found: Found) -> str:
    """Of the data."""
    timed = any(results.offset_ms for results in found)
    return f"What was touched{', and when each finger touched it' if timed else ''}."


def contact(found: Found) -> str:
    """Of contact detection."""
    said = ["20 ms windows, 3 ms of them new.", *map(_start, starts_at(found))]
    if any(names.detectors(results.contact) for results in found):
        said.append(
            "Where a contact is placed and when that is decided are two things, because a "
            "detector looks back from its trigger: both are scored."
        )
    return " ".join(said)


def waveforms(found: Found) -> str:
    """Of the responses."""
    return "The first 15 ms of vibration, of the finger that touched."


def blocks(found: Found) -> str:
    """Of discrimination and regression."""
    return (
        "Every number stands on its floors: the mean (or most frequent class) of what was "
        "learned, and the peak amplitude alone. Small numbers are 95 % bootstrap intervals."
    )


def objects(found: Found) -> str:
    """Of unseen objects, with how many there are."""
    counts = [scores.over_objects.n for results in found for scores in results.objects.values()]
    known = list(dict.fromkeys(map(str, counts)))
    many = f" ({' and '.join(known)} here)" if known else ""
    return (
        f"No model has learned from these objects. Small numbers are 95 % bootstrap intervals over "
        f"whole objects{many}."
    )


def short(found: Found) -> str:
    """Of short windows."""
    said = (
        "The class of hardness from the first milliseconds, by models that never met the material. "
        "Accuracy is the mean over materials, then over classes: a material counts once however "
        "many pinches there are of it. The rule is the same for all materials: kind of input and "
        "regularisation are chosen on the other materials, each left out in turn."
    )
    if detector_learned(found):
        said += (
            " The detector that places windows never learned from the session, but may have met "
            "the material in another."
        )
    return said


def nothing(found: Found) -> str:
    """Of what its title says all."""
    return ""


def hardness(found: Found) -> str:
    """Of the order of hardness."""
    order = "whether materials come in the right order of hardness"
    if any(results.blocks or results.objects for results in found):
        return f"By their ranks: {order}. Errors in Shore A stand above."
    return f"No error in Shore A can be given from these labels: only {order}."


def answer(found: Found) -> str:
    """Of the time to an answer."""
    place = "label of the first contact" if Accepted.of(found).early else "first contact"
    said = f"How long after the {place} a stiffness could be told"
    if any(results.answer_ms and results.answer_ms.with_second for results in found):
        return f"{said}, and in how many pinches that is before the other finger touches."
    return f"{said}."


def anytime(found: Found) -> str:
    """Of answers at any time."""
    return (
        "One pre-trained network that is told of the rig by its own block pinches answers at any "
        "moment; nothing is trained here. Later signal is not looked at, nor anything after the "
        "second contact."
    )


def generalise(found: Found) -> str:
    """Of estimators off their blocks."""
    return (
        "Hands, specimens and sessions of seeds that no choice was made on. Everybody learns from "
        "the same block pinches and is asked about the same contacts, which are as late as the "
        "detector placed those above. Another hand: 30 of its own block pinches alone. Three "
        "pinches: the mean answer. Level left out: mean over 20, 29 and 43 Shore A. Floor: what "
        "may learn from other specimens of these kinds of object on the very rig. Ceiling: told "
        "the modulus, part of the error is the label's; told the contact's stiffness, what no "
        "piezo can tell apart."
    )


def shared(found: Found) -> str:
    """What both sides of splits have in common."""
    said = []
    folds = [results.contact.about.folds for results in found]
    if any(its and its.n > 1 for its in folds):
        said.append(
            "Folds of contact detection hold out sessions where those are known, and share "
            "specimens."
        )
    if detector_learned(found) and any(
        any(scores.leave_one_shore_out for scores in results.blocks.values())
        or (results.hardness_order and results.hardness_order.leave_one_material_out)
        for results in found
    ):
        said.append(
            "The detector places the windows of a Shore A level or material that is left out, and "
            "has learned from it; only the estimator has not."
        )
    return " ".join(said)


def briefly(found: Found) -> str:
    """How estimators learned quickly, for a quick study."""
    used = {name for results in found for name in (*results.blocks, *results.objects)}
    said = [
        f"{entry.title} ({', '.join(f'{key} {value}' for key, value in entry.quick.items())})"
        for name, entry in window_estimators().items()
        if name in used and entry.quick
    ]
    return f" Briefly trained: {', '.join(said)}." if said else ""
