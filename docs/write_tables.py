"""Write the tables of results in the README and the docs from results files.

    python docs/write_tables.py                     the tables, from docs/results
    python docs/write_tables.py --study A --real B --strikes C --grasp D --sets E  copy them

Tables stand between ``<!-- numbers: NAME -->`` and ``<!-- /numbers -->``. Nothing in them is
typed by hand, and a test holds them against docs/results.
"""

from __future__ import annotations

import argparse
import json
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Generic, TypeVar

from firstcontact.core.by_name import to_tree
from firstcontact.grasp_study import chapters as grasp_chapters
from firstcontact.grasp_study.results import GraspResults
from firstcontact.learning.detection import DetectionScores
from firstcontact.learning.scores import Bounded, bounded
from firstcontact.report._tables import Cell, Table
from firstcontact.report.accepted import Accepted
from firstcontact.report.comparison import percent
from firstcontact.report.markdown import TABLES, markdown
from firstcontact.report.results.anytime import AnytimeResults
from firstcontact.report.results.contact import AnswerTimes
from firstcontact.report.results.data import Offsets
from firstcontact.report.results.file import read_results
from firstcontact.report.results.hardness import HardnessOrder
from firstcontact.report.results.real import RealSet
from firstcontact.report.results.sets import SetsResults
from firstcontact.report.results.stiffness import InferenceTimes
from firstcontact.report.results.study import FirstSubject, StudyResults, SubjectResults
from firstcontact.report.sets_page import noises, overview
from firstcontact.stiffness.registry import ESTIMATORS
from firstcontact.stiffness.timing import InferenceTime

ROOT = Path(__file__).parents[1]
RESULTS = ROOT / "docs" / "results"
TABLE = re.compile(
    r"(?P<open><!-- numbers: (?P<name>\w+) -->\n).*?(?P<close><!-- /numbers -->)", re.DOTALL
)
ABSENT = "–"


#: How a kind of value is shown, and what it is multiplied by; a share is shown by `percent`.
FORMS = {
    "count": ("{:.0f}", 1.0),
    "rate": ("{:.1f}", 1.0),
    "ms": ("{:.2f} ms", 1.0),
    "us": ("{:.0f} µs", 1.0),
    "s": ("{:.0f} s", 1.0),
    "ratio": ("{:.1f} times", 1.0),
    "shore": ("{:.2f}", 1.0),
    "p": ("{:.3f}", 1.0),
}


R = TypeVar("R")
S = TypeVar("S")
Number = float | Bounded | None


@dataclass(frozen=True)
class Row(Generic[R]):
    """One row: what it is, its number in some results, what kind it is, what was published."""

    label: str
    number: Callable[[R], Number]
    kind: str
    published: str = ABSENT

    def cell(self, results: R, intervals: bool = True) -> str:
        """The number with its 95 % interval, if it has one and it is wanted, or a dash."""
        found = self.number(results)
        if found is None:
            return ABSENT
        value, ends = found if isinstance(found, Bounded) else Bounded(found)
        shown = self._text(value)
        if intervals and ends:
            low, high = (self._text(end).split(" ")[0] for end in ends)
            shown += f" ({low} to {high})"
        return shown

    def _text(self, value: float) -> str:
        if self.kind == "share":
            return percent(value)
        form, factor = FORMS[self.kind]
        return form.format(factor * value)


def of(find: Callable[[R], S | None], number: Callable[[S], Number]) -> Callable[[R], Number]:
    """A number of a record that need not be there."""

    def found(results: R) -> Number:
        record = find(results)
        return None if record is None else number(record)

    return found


Rows = list[Row[SubjectResults]]


def contact(key: str, name: str, published: str, accepted: Accepted) -> Rows:
    """Rows of a detector, which say what was accepted."""
    after = " after its label" if accepted.early else ""

    def its(number: Callable[[DetectionScores], Number]) -> Callable[[SubjectResults], Number]:
        return of(lambda r: r.contact.get(key), number)

    return [
        Row(
            f"contact, {name}: windows right", its(lambda s: s.window_accuracy), "share", published
        ),
        Row(
            f"contact, {name}: contact windows found",
            its(lambda s: s.contact_windows_found),
            "share",
        ),
        Row(
            f"contact, {name}: placed {accepted.placed}, pinches",
            its(lambda s: s.pinch_success),
            "share",
        ),
        Row(
            f"contact, {name}: and decided {accepted.decided}",
            its(lambda s: s.decided_within_3_ms),
            "share",
        ),
        Row(
            f"contact, {name}: false alarms a minute",
            its(lambda s: s.false_alarms_per_minute),
            "rate",
        ),
        Row(
            f"contact, {name}: median delay of the decision{after}",
            its(lambda s: s.median_delay),
            "ms",
        ),
    ]


def stiffness(key: str, name: str, accuracy: str, error: str) -> Rows:
    """Rows of a model."""

    def blocks(split: str, score: str) -> Callable[[SubjectResults], Number]:
        return of(lambda r: r.blocks.get(key), lambda s: bounded(s.split(split), score))

    def objects(score: str) -> Callable[[SubjectResults], Number]:
        return lambda r: bounded(r.objects.get(key), score)

    random = blocks("random_90_10", "accuracy")
    return [
        Row(f"5 blocks, {name}: accuracy, random 90/10", random, "share", accuracy),
        Row(f"5 blocks, {name}: accuracy, by session", blocks("by_session", "accuracy"), "share"),
        Row(f"5 blocks, {name}: RMSE, by session", blocks("by_session", "rmse"), "shore"),
        Row(f"8 unseen objects, {name}: RMSE", objects("rmse"), "shore"),
        Row(f"8 unseen objects, {name}: MAE", objects("mae"), "shore"),
        Row(f"8 unseen objects, {name}: MSE", objects("mse"), "shore", error),
    ]


def at_any_time(ms: str) -> Callable[[SubjectResults], Number]:
    """Error so long after the contact."""

    def found(a: AnytimeResults) -> Number:
        ends = a.intervals.get("rmse", {}).get(ms)
        return Bounded(a.rmse[ms], ends) if ms in a.rmse else None

    return of(lambda r: r.anytime, found)


def times(key: str) -> Callable[[SubjectResults], InferenceTimes | None]:
    """How long a model takes."""
    return lambda r: (r.inference_us or {}).get(key)


def speed(key: str, name: str, published: str) -> Rows:
    """Rows of a model's inference."""

    def classifier(r: SubjectResults) -> InferenceTime | None:
        found = times(key)(r)
        return found.classification if found else None

    return [
        Row(f"{name}: one window, median", of(times(key), lambda t: t.p50), "us", published),
        Row(f"{name}: one window, p99", of(times(key), lambda t: t.p99), "us"),
        Row(
            f"{name}: p99 with preempted calls",
            of(times(key), lambda t: t.p99_with_preempted),
            "us",
        ),
        Row(
            f"{name}: faster than its training library",
            of(times(key), lambda t: t.speedup),
            "ratio",
        ),
        Row(f"{name} classifier: one window, p99", of(classifier, lambda t: t.p99), "us"),
        Row(
            f"{name} classifier: faster than its training library",
            of(classifier, lambda t: t.speedup),
            "ratio",
        ),
    ]


def answer(number: Callable[[AnswerTimes], Number]) -> Callable[[SubjectResults], Number]:
    """Of the time to an answer."""
    return of(lambda r: r.answer_ms, number)


def detection(found: Sequence[SubjectResults]) -> Rows:
    """Rows of both detectors and of the time to an answer."""
    accepted = Accepted.of(found)
    start = "label of the first contact" if accepted.early else "first contact"
    return [
        *contact("three_sigma", "3σ", "90.6 %", accepted),
        *contact("svm", "SVM", "100 %", accepted),
        Row(f"{start} to a complete 15 ms window, median", answer(lambda a: a.median), "ms"),
        Row("– before the second contact", answer(lambda a: a.before_second), "share"),
        Row("– at any time", of(lambda r: r.anytime, lambda a: a.before_second), "share"),
    ]


def offset(number: Callable[[Offsets], Number]) -> Callable[[SubjectResults], Number]:
    """Of the time between the contacts."""
    return of(lambda r: r.offset_ms, number)


def order(number: Callable[[HardnessOrder], Number]) -> Callable[[SubjectResults], Number]:
    """Of the order of hardness."""
    return of(lambda r: r.hardness_order, number)


def left_out(model: str) -> Callable[[SubjectResults], Number]:
    """Accuracy of the class of a material that was left out."""
    return order(lambda h: bounded(h.classes_left_out().get(model), "accuracy"))


def pinches(results: SubjectResults) -> Number:
    """How many there are."""
    return results.data.pinches if results.data else None


OFFSETS = [
    Row("pinches", pinches, "count", "2500 + objects"),
    Row("first to second contact, mean", offset(lambda o: o.mean), "ms", "16.65 ms"),
    Row("first to second contact, SD", offset(lambda o: o.sd), "ms", "10.35 ms"),
    Row("second contact within 15 ms", offset(lambda o: o.share_below_15), "share"),
]
STIFFNESS = [
    *stiffness("svm", "SVM", "97.2 %", "4.17 (as “MSE”)"),
    *stiffness("cnn", "CNN", "98.6 %", "2.39 (as “MSE”)"),
    *(
        Row(f"8 unseen objects, in-context network: RMSE, {ms} ms", at_any_time(ms), "shore")
        for ms in ("3", "5", "15")
    ),
]
SPEED = [
    Row("load of the machine meanwhile", of(times("svm"), lambda t: t.load), "rate"),
    *speed("svm", "SVM", "< 1 ms"),
    *speed("cnn", "CNN", "1.4 ms"),
    Row("the whole study", lambda r: r.seconds if isinstance(r, FirstSubject) else None, "s"),
]
#: What the README shows: no intervals, which stand beside the same numbers in the results.
HEADLINE: Rows = [
    Row(
        "answers before the second contact",
        of(lambda r: r.anytime, lambda a: a.before_second),
        "share",
    ),
    Row(
        "8 unseen objects: RMSE, Shore A, 5 ms after contact",
        of(lambda r: r.anytime, lambda a: a.rmse.get("5")),
        "shore",
    ),
    Row(
        "– the published SVM, 15 ms after contact", lambda r: bounded(r.objects.get("svm"), "rmse"),
        "shore",
    ),
]  # fmt: skip
IMPACTS: Rows = [Row("impacts", pinches, "count")]
MATERIALS = [
    Row("materials", order(lambda h: h.spectral_centroid.n), "count"),
    Row(
        "Spearman, hardness and spectral centroid",
        order(lambda h: h.spectral_centroid.rho),
        "shore",
    ),
    Row("– its two-sided p", order(lambda h: h.spectral_centroid.p), "p"),
    Row("Spearman, SVM, material left out", order(lambda h: h.rho_left_out), "shore"),
    Row("accuracy of the class, SVM, material left out", left_out("svm"), "share"),
    Row("– peak alone, material left out", left_out("peak"), "share"),
    Row("– by chance", order(lambda h: h.chance), "share"),
    Row(
        "– SVM, random folds",
        order(lambda h: bounded((h.random_folds or {}).get("svm"), "accuracy")),
        "share",
    ),
]

#: Tables of the grasp study, as its report has them.
GRASP: Mapping[str, Callable[[GraspResults], grasp_chapters.Table]] = {
    "grasp": lambda found: grasp_chapters.policies_table(found.household),
    "grasp_reflex": lambda found: grasp_chapters.reflex_table(found.household),
    "grasp_controls": lambda found: grasp_chapters.controls_table(found.household),
    "grasp_closings": lambda found: grasp_chapters.closings_table(found.household),
    "grasp_estimates": lambda found: grasp_chapters.estimates_table(found.household),
    "grasp_sensitivity": lambda found: grasp_chapters.sensitivity_table(found.household),
    "grasp_payload": grasp_chapters.payload_table,
}


def grasp_table(found: grasp_chapters.Table) -> str:
    """One of them, with its caption."""
    lines = [found.head, ["---"] * len(found.head), *found.rows]
    return f"{found.caption}\n\n" + "".join("| " + " | ".join(cells) + " |\n" for cells in lines)


def table(
    rows: Rows, columns: Mapping[str, SubjectResults], published: bool, intervals: bool = True
) -> str:
    """A Markdown table; rows that no column has are left out."""
    head = ["", *(["published"] if published else []), *columns]
    lines = [head, ["---"] * len(head)]
    for row in rows:
        cells = [row.cell(results, intervals) for results in columns.values()]
        if any(cell != ABSENT for cell in cells):
            lines.append([row.label, *([row.published] if published else []), *cells])
    return "".join("| " + " | ".join(cells) + " |\n" for cells in lines)


def short_windows(found: RealSet) -> str:
    """A row a reading: balanced accuracy of materials left out, by length of the window."""
    lengths = list(found.material_held_out)
    lines = [["material left out", *(f"{ms} ms" for ms in lengths)], ["---"] * (1 + len(lengths))]
    for reading in found.readings:
        title = ESTIMATORS[reading.estimator].title
        signal = "published smoothing" if reading.conditioned else "signal as sent"
        start = "labelled" if reading.known_contacts else "detected"
        shares = [percent(reading.material_held_out[ms]) for ms in lengths]
        lines.append([f"{title}, {signal}, {start} contacts", *shares])
    for material, its in sorted(found.by_material.items(), key=lambda i: (i[1].rank, i[0])):
        shares = [percent(its.accuracy[ms]) if ms in its.accuracy else ABSENT for ms in lengths]
        name = material.replace("_", " ")
        lines.append([f"– {name} (rank {its.rank:g}, n = {its.n})", *shares])
    order = (
        []
        if found.rho is None
        else [
            f"\nOrder of hardness by the spectral centroid, nothing fitted: ρ = {found.rho:.2f} "
            f"(n = {found.materials} materials, p = {found.p:.3f}; a perfect order has "
            f"{found.most_rho:.2f}).\n"
        ]
    )
    return "".join(["| " + " | ".join(cells) + " |\n" for cells in lines] + order)


def tables(results: Path) -> dict[str, str]:
    """All tables by name, of the results that are there."""
    names = ("headline", "study", "speed", "real", "impacts", "strikes", "sets", "noises")
    names = (*names, "grasp_headline", "grasp_short")
    made = dict.fromkeys((*names, *GRASP, *TABLES), "*Not run yet.*\n")
    if (results / "study.json").is_file():
        study = read_results(results / "study.json", StudyResults)
        conditions = {"paper rig": study.about, **study}
        rows = [*OFFSETS, *detection(list(conditions.values())), *STIFFNESS]
        made["headline"] = table(HEADLINE, conditions, published=False, intervals=False)
        made["study"] = table(rows, conditions, published=True)
        for name in TABLES:
            made[name] = markdown(name, conditions) or made[name]
        made["speed"] = table(SPEED, conditions, published=True)
    if (results / "real.json").is_file():
        real = read_results(results / "real.json", StudyResults).about
        rows = [*IMPACTS, *detection([real]), *MATERIALS]
        made["real"] = table(rows, {"here": real}, published=False)
    for name, file in (("impacts", "real.json"), ("strikes", "strikes.json")):
        if (results / file).is_file():
            sets = read_results(results / file, StudyResults).about.real or {}
            made[name] = "".join(map(short_windows, sets.values())) or made[name]
    if (results / "grasp.json").is_file():
        grasp = read_results(results / "grasp.json", GraspResults)
        made["grasp_short"] = grasp_chapters.shortly(grasp.household) + "\n"
        made["grasp_headline"] = "".join(f"- {said}\n" for said in grasp_chapters.sentences(grasp))
        for name, of in GRASP.items():
            made[name] = grasp_table(of(grasp))
    if (results / "sets.json").is_file():
        sets = read_results(results / "sets.json", SetsResults)
        made["sets"] = columns_of(overview(sets))
        made["noises"] = columns_of(noises(sets)) if sets.noises else made["noises"]
    return made


def columns_of(its: Table) -> str:
    """A table on its side: a column for each of its rows."""
    columns = [list(its.head), *([_cell(c) for c in row.cells] for row in its.rows)]
    head, *lines = zip(*columns, strict=True)
    rows = [("", *head[1:]), ("---",) * len(head), *lines]
    return "".join(f"| {' | '.join(row)} |\n" for row in rows)


def _cell(cell: Cell) -> str:
    return f"{cell.text} ({cell.small})" if cell.small else cell.text


def copy(source: Path, name: str) -> None:
    """Copy results into the docs; where the data lay on the machine of the run is left out."""
    kinds: dict[str, Any] = {"grasp": GraspResults, "sets": SetsResults}
    tree = to_tree(read_results(source, kinds.get(name, StudyResults)))
    run = tree if name == "sets" else tree["study"]
    run.pop("asked", None)
    run["command"] = re.sub(r"(?<![^\s=])[^\s=]*/", "", run["command"])
    text = json.dumps(tree, indent=1, ensure_ascii=False) + "\n"
    (RESULTS / f"{name}.json").write_text(text, encoding="utf-8")


def filled(text: str, made: dict[str, str]) -> str:
    """A page with its tables in place.

    Raises
    ------
    KeyError
        The page asks for a table that does not exist.
    """
    return TABLE.sub(lambda m: f"{m['open']}\n{made[m['name']]}\n{m['close']}", text)


def pages(root: Path) -> list[Path]:
    """The pages that may have tables."""
    return [root / "README.md", *sorted(root.glob("docs/**/*.md"))]


def main() -> None:
    """Copy results if asked to, then write the tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--study", type=Path, help="results.json of `make study`")
    parser.add_argument("--real", type=Path, help="results.json of the impacts of `make real`")
    parser.add_argument("--strikes", type=Path, help="results.json of its strikes")
    parser.add_argument("--sets", type=Path, help="results.json of `make real`")
    parser.add_argument("--grasp", type=Path, help="results.json of `firstcontact grasp-study`")
    options = parser.parse_args()
    RESULTS.mkdir(exist_ok=True)
    for name, source in (
        ("study", options.study),
        ("real", options.real),
        ("strikes", options.strikes),
        ("grasp", options.grasp),
        ("sets", options.sets),
    ):
        if source is not None:
            copy(source, name)
    made = tables(RESULTS)
    for page in pages(ROOT):
        text = page.read_text(encoding="utf-8")
        if (new := filled(text, made)) != text:
            page.write_text(new, encoding="utf-8")
            print(f"wrote {page.relative_to(ROOT)}")


if __name__ == "__main__":
    main()
