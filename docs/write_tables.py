"""Write the tables of results in the README and the docs from results files.

    python docs/write_tables.py                     the tables, from docs/results
    python docs/write_tables.py --study A --real B --grasp C  copy them to docs/results first

Tables stand between ``<!-- numbers: NAME -->`` and ``<!-- /numbers -->``. Nothing in them is
typed by hand, and a test holds them against docs/results.
"""

from __future__ import annotations

import argparse
import json
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from firstcontact.grasp.policy import Part
from firstcontact.grasp_study.variants import playing, variants
from firstcontact.report.accepted import Accepted
from firstcontact.report.comparison import percent

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
    "newton": ("{:.2f} N", 1.0),
    "change": ("{:+z.0f} %", 100.0),
    "whole_ms": ("{:.0f} ms", 1.0),
    "p": ("{:.3f}", 1.0),
}


@dataclass(frozen=True)
class Row:
    """One row: what it is, where it lies in the results, what kind it is, what was published."""

    label: str
    path: str
    kind: str
    published: str = ABSENT

    def cell(self, tree: Any, intervals: bool = True) -> str:
        """The value in a tree of results, with its 95 % interval if wanted, or a dash."""
        *way, last = self.path.split(".")
        for key in way:
            tree = tree.get(key) if isinstance(tree, dict) else None
        if not isinstance(tree, dict) or last not in tree:
            return ABSENT
        shown = self._text(tree[last])
        if intervals and (ends := tree.get("intervals", {}).get(last)):
            low, high = (self._text(end).split(" ")[0] for end in ends)
            shown += f" ({low} to {high})"
        return shown

    def _text(self, value: float) -> str:
        if self.kind == "share":
            return percent(value)
        form, factor = FORMS[self.kind]
        return form.format(factor * value)


def contact(key: str, name: str, published: str, accepted: Accepted) -> list[Row]:
    """Rows of a detector, which say what was accepted."""
    at = f"contact.{key}"
    after = " after its label" if accepted.early else ""
    return [
        Row(f"contact, {name}: windows right", f"{at}.window_accuracy", "share", published),
        Row(f"contact, {name}: contact windows found", f"{at}.contact_windows_found", "share"),
        Row(f"contact, {name}: placed {accepted.placed}, pinches", f"{at}.pinch_success", "share"),
        Row(
            f"contact, {name}: and decided {accepted.decided}", f"{at}.decided_within_3_ms", "share"
        ),
        Row(f"contact, {name}: false alarms a minute", f"{at}.false_alarms_per_minute", "rate"),
        Row(f"contact, {name}: median delay of the decision{after}", f"{at}.delay_ms.median", "ms"),
    ]


def stiffness(key: str, name: str, accuracy: str, error: str) -> list[Row]:
    """Rows of a model."""
    blocks, objects = f"blocks.{key}", f"objects.{key}"
    random, session = f"{blocks}.random_90_10", f"{blocks}.by_session"
    return [
        Row(f"5 blocks, {name}: accuracy, random 90/10", f"{random}.accuracy", "share", accuracy),
        Row(f"5 blocks, {name}: accuracy, by session", f"{session}.accuracy", "share"),
        Row(f"5 blocks, {name}: RMSE, by session", f"{session}.rmse", "shore"),
        Row(f"8 unseen objects, {name}: RMSE", f"{objects}.rmse", "shore"),
        Row(f"8 unseen objects, {name}: MAE", f"{objects}.mae", "shore"),
        Row(f"8 unseen objects, {name}: MSE", f"{objects}.mse", "shore", error),
    ]


def speed(key: str, name: str, published: str) -> list[Row]:
    """Rows of a model's inference."""
    at = f"inference_us.{key}"
    return [
        Row(f"{name}: one window, median", f"{at}.p50", "us", published),
        Row(f"{name}: one window, p99", f"{at}.p99", "us"),
        Row(f"{name}: p99 with preempted calls", f"{at}.p99_with_preempted", "us"),
        Row(f"{name}: faster than its training library", f"{at}.speedup", "ratio"),
        Row(f"{name} classifier: one window, p99", f"{at}.classification.p99", "us"),
        Row(
            f"{name} classifier: faster than its training library",
            f"{at}.classification.speedup",
            "ratio",
        ),
    ]


def detection(trees: Sequence[Any]) -> list[Row]:
    """Rows of both detectors and of the time to an answer."""
    accepted = Accepted.of(trees)
    start = "label of the first contact" if accepted.early else "first contact"
    return [
        *contact("three_sigma", "3σ", "90.6 %", accepted),
        *contact("svm", "SVM", "100 %", accepted),
        Row(f"{start} to a complete 15 ms window, median", "answer_ms.median", "ms"),
        Row("– before the second contact", "answer_ms.before_second", "share"),
    ]


OFFSETS = [
    Row("pinches", "data.pinches", "count", "2500 + objects"),
    Row("first to second contact, mean", "offset_ms.mean", "ms", "16.65 ms"),
    Row("first to second contact, SD", "offset_ms.sd", "ms", "10.35 ms"),
    Row("second contact within 15 ms", "offset_ms.share_below_15", "share"),
]
STIFFNESS = [
    *stiffness("svm", "SVM", "97.2 %", "4.17 (as “MSE”)"),
    *stiffness("cnn", "CNN", "98.6 %", "2.39 (as “MSE”)"),
]
SPEED = [
    Row("load of the machine meanwhile", "inference_us.svm.load", "rate"),
    *speed("svm", "SVM", "< 1 ms"),
    *speed("cnn", "CNN", "1.4 ms"),
    Row("the whole study", "seconds", "s"),
]
#: What the README shows: no intervals, which stand beside the same numbers in the results.
HEADLINE = [
    Row("first contacts placed within ±3 ms (SVM)", "contact.svm.pinch_success", "share"),
    Row("estimates before the second contact", "answer_ms.before_second", "share"),
    Row("5 levels of stiffness told apart (SVM)", "blocks.svm.by_session.accuracy", "share"),
    Row("8 unseen objects: RMSE, Shore A (SVM)", "objects.svm.rmse", "shore"),
]
LEFT_OUT = "hardness_order.leave_one_material_out"
CLASSES = f"{LEFT_OUT}.classification"
IMPACTS = [Row("impacts", "data.pinches", "count")]
MATERIALS = [
    Row("materials", "hardness_order.spectral_centroid.n", "count"),
    Row(
        "Spearman, hardness and spectral centroid", "hardness_order.spectral_centroid.rho", "shore"
    ),
    Row("– its two-sided p", "hardness_order.spectral_centroid.p", "p"),
    Row("Spearman, SVM, material left out", f"{LEFT_OUT}.rank_regression.rho", "shore"),
    Row("accuracy of the class, SVM, material left out", f"{CLASSES}.svm.accuracy", "share"),
    Row("– peak alone, material left out", f"{CLASSES}.peak.accuracy", "share"),
    Row("– by chance", "hardness_order.chance", "share"),
    Row("– SVM, random folds", "hardness_order.random_folds.svm.accuracy", "share"),
]

#: The columns of one latency.
GRASP = [
    Row("", "soft.peak_n", "newton"),
    Row("", "lasting.time_ms", "whole_ms"),
    Row("", "brittle.broken", "share"),
    Row("", "all.dropped", "share"),
]


def grasp_table(tree: Any) -> str:
    """A row a policy, at the headline's latency."""
    ms = f"{tree['headline']['latency_ms']:g}"
    lines = [["", "peak force, soft objects", "time to grasp", "brittle broken", "dropped"]]
    lines.append(["---"] * len(lines[0]))
    for key, variant in variants().items():
        if key in tree["policies"]:
            lines.append([variant.title, *(row.cell(tree["policies"][key][ms]) for row in GRASP)])
    return "".join("| " + " | ".join(cells) + " |\n" for cells in lines)


def target_table(tree: Any) -> str:
    """What is saved against each other policy, at the headline's latency."""
    lines = [["", "against", "peak force, soft", "time to grasp", "drops", "broken"]]
    lines.append(["---"] * len(lines[0]))
    for ours in playing(Part.CANDIDATE):
        for other, found in tree["headline"].get(ours.key, {}).items():
            less = {
                "change": -found["soft"]["less_peak"],
                "intervals": {
                    "change": [-end for end in reversed(found["soft"]["intervals"]["less_peak"])]
                },
            }
            cells = [
                Row("", "change", "change").cell(less),
                Row("", "longer", "change").cell(found["lasting"]),
                f"{found['all']['more_dropped']:+d}",
                f"{found['all']['more_broken']:+d}",
            ]
            lines.append([ours.title, variants()[other].title, *cells])
    return "".join("| " + " | ".join(cells) + " |\n" for cells in lines)


def table(
    rows: Sequence[Row], columns: dict[str, Any], published: bool, intervals: bool = True
) -> str:
    """A Markdown table; rows that no column has are left out."""
    head = ["", *(["published"] if published else []), *columns]
    lines = [head, ["---"] * len(head)]
    for row in rows:
        cells = [row.cell(tree, intervals) for tree in columns.values()]
        if any(cell != ABSENT for cell in cells):
            lines.append([row.label, *([row.published] if published else []), *cells])
    return "".join("| " + " | ".join(cells) + " |\n" for cells in lines)


def tables(results: Path) -> dict[str, str]:
    """All tables by name, of the results that are there."""
    names = ("headline", "study", "speed", "real", "grasp", "grasp_target")
    made = dict.fromkeys(names, "*Not run yet.*\n")
    if (results / "study.json").is_file():
        tree = json.loads((results / "study.json").read_text(encoding="utf-8"))
        conditions = {"paper rig": tree}
        if "everyday" in tree:
            conditions["everyday"] = tree["everyday"]
        rows = [*OFFSETS, *detection(list(conditions.values())), *STIFFNESS]
        made["headline"] = table(HEADLINE, conditions, published=False, intervals=False)
        made["study"] = table(rows, conditions, published=True)
        made["speed"] = table(SPEED, conditions, published=True)
    if (results / "real.json").is_file():
        tree = json.loads((results / "real.json").read_text(encoding="utf-8"))
        rows = [*IMPACTS, *detection([tree]), *MATERIALS]
        made["real"] = table(rows, {"here": tree}, published=False)
    if (results / "grasp.json").is_file():
        tree = json.loads((results / "grasp.json").read_text(encoding="utf-8"))
        made["grasp"] = grasp_table(tree)
        made["grasp_target"] = target_table(tree)
    return made


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
    parser.add_argument("--real", type=Path, help="results.json of `make real`")
    parser.add_argument("--grasp", type=Path, help="results.json of `firstcontact grasp-study`")
    options = parser.parse_args()
    RESULTS.mkdir(exist_ok=True)
    for name, source in (
        ("study", options.study),
        ("real", options.real),
        ("grasp", options.grasp),
    ):
        if source is not None:
            tree = json.loads(source.read_text(encoding="utf-8"))
            # Where the data lay on the machine of the run is nobody's business.
            tree["study"].pop("asked", None)
            tree["study"]["command"] = re.sub(r"/\S*/", "", tree["study"]["command"])
            text = json.dumps(tree, indent=1, ensure_ascii=False) + "\n"
            (RESULTS / f"{name}.json").write_text(text, encoding="utf-8")
    made = tables(RESULTS)
    for page in pages(ROOT):
        text = page.read_text(encoding="utf-8")
        if (new := filled(text, made)) != text:
            page.write_text(new, encoding="utf-8")
            print(f"wrote {page.relative_to(ROOT)}")


if __name__ == "__main__":
    main()
