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
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from study_rows import HEADLINE, IMPACTS, MATERIALS, OFFSETS, SPEED, STIFFNESS, detection
from table_rows import ABSENT, columns_of, lined, table

from firstcontact.core import percent, to_tree
from firstcontact.models import ESTIMATORS
from firstcontact_lab.grasping import chapters as grasp_chapters
from firstcontact_lab.grasping import sentences as grasp_sentences
from firstcontact_lab.grasping.results import GraspResults
from firstcontact_lab.report.markdown import TABLES, markdown
from firstcontact_lab.report.results.file import read_results
from firstcontact_lab.report.results.real import RealSet
from firstcontact_lab.report.results.sets import SetsResults
from firstcontact_lab.report.results.study import StudyResults
from firstcontact_lab.report.sets_page import noises, overview

ROOT = Path(__file__).parents[1]
RESULTS = ROOT / "docs" / "results"
TABLE = re.compile(
    r"(?P<open><!-- numbers: (?P<name>\w+) -->\n).*?(?P<close><!-- /numbers -->)", re.DOTALL
)

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
    return f"{found.caption}\n\n{lined(lines)}"


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
        ""
        if found.rho is None
        else (
            f"\nOrder of hardness by the spectral centroid, nothing fitted: ρ = {found.rho:.2f} "
            f"(n = {found.materials} materials, p = {found.p:.3f}; a perfect order has "
            f"{found.most_rho:.2f}).\n"
        )
    )
    return lined(lines) + order


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
        made["grasp_short"] = grasp_sentences.shortly(grasp.household) + "\n"
        made["grasp_headline"] = "".join(f"- {said}\n" for said in grasp_sentences.sentences(grasp))
        for name, of in GRASP.items():
            made[name] = grasp_table(of(grasp))
    if (results / "sets.json").is_file():
        sets = read_results(results / "sets.json", SetsResults)
        made["sets"] = columns_of(overview(sets))
        made["noises"] = columns_of(noises(sets)) if sets.noises else made["noises"]
    return made


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
