"""Write the tables of results in the README and the docs from results files.

    python docs/write_tables.py                     write the tables from docs/results
    python docs/write_tables.py --study A --generalise B --real C ...   copy results there first

Tables are between ``<!-- numbers: NAME -->`` and ``<!-- /numbers -->``. Nothing in them is typed by
hand: a test compares them with docs/results.
"""

from __future__ import annotations

import argparse
import json
import re
import shutil
from base64 import b64decode
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

from firstcontact.core.records import to_tree
from firstcontact_lab.grasping import page as grasp_page
from firstcontact_lab.grasping import sentences as grasp_sentences
from firstcontact_lab.grasping.page import HOUSEHOLD
from firstcontact_lab.grasping.results import Household
from firstcontact_lab.report.findings import SECONDS, named_subjects
from firstcontact_lab.report.results import SubjectResults
from firstcontact_lab.report.tables import (
    ABSENT,
    Cell,
    Line,
    Row,
    Table,
    fill,
    format_cell,
    markdown,
    markdown_table,
    optional,
    row_table,
)
from firstcontact_lab.study.page import read_study, rows
from firstcontact_lab.study.parts import PARTS
from firstcontact_lab.study.parts.answer_time import ANSWER
from firstcontact_lab.study.parts.in_force import IN_FORCE
from firstcontact_lab.study.parts.objects import OBJECTS
from firstcontact_lab.study.parts.stiffness import STIFFNESS
from firstcontact_lab.study.sets import noise_tables, overview, stiffness_curves

ROOT = Path(__file__).parents[1]
RESULTS = ROOT / "docs" / "results"
#: Tables of the grasp study, as its report has them.
GRASP: Mapping[str, Callable[[Household], Table]] = {
    "grasp": grasp_page.policies_table,
    "grasp_reflex": grasp_page.reflex_table,
    "grasp_controls": grasp_page.controls_table,
    "grasp_estimates": grasp_page.estimates_table,
    "grasp_sensitivity": grasp_page.sensitivity_table,
}
#: Rows of the study that the results page shows first.
MAIN = (
    "First to second contact, mean",
    "Contact, Logistic: placed within ±3 ms",
    "Contact, Logistic: and decided within 3 ms",
    "Contact, Logistic: false alarms a minute",
    "Blocks, SVM, by session: RMSE",
    "Unseen objects, SVM: RMSE",
    "Unseen objects, CNN: RMSE",
    "Unseen objects, Network and own pinches, 5 ms: RMSE",
    "Pinches with an estimate in force at the second contact",
    "Unseen objects, estimate in force: RMSE",
)
#: Tables of study parts that the lab notes show shortened: for each table, places of its columns
#: and the starts of its lines. A table without an entry is left out, since docs/results has it.
EXCERPTS: Mapping[str, Sequence[tuple[Sequence[int], tuple[str, ...]]]] = {
    "anytime": [((1, 3, 5), ("RMSE", "Coverage")), ((1, 3, 5), ("RMSE",))],
    "random_rigs": [
        ((1, 2, 4, 5, 6), ("Network", "SVM", "Average")),
        ((3, 4), ("Network", "Average of", "Average, radius and")),
    ],
    "closing_speed": [((1, 2), ("Combined",)), ((1, 2), ("Combined",))],
    "structure": [((1, 5, 8, 9, 11), ("Shipped", "Detector from"))],
    "short_windows": [((1, 3, 5), ("",)), ((3, 5, 6), ("",))],
}
#: Part of a study whose rows depend on the computer.
TIMED = "inference"


def captioned(*tables: Table | None, title: str = "") -> str:
    """Return tables with their captions as Markdown."""
    heading = f"**{title.capitalize()}.** " if title else ""
    return "\n".join(f"{heading}{t.caption}\n\n{markdown(t)}" for t in tables if t)


def excerpt(table: Table, places: Sequence[int], starts: tuple[str, ...]) -> Table:
    """Return the columns at ``places`` and the lines that begin with one of ``starts``."""
    return Table(
        table.caption,
        [table.head[place] for place in (0, *places)],
        [
            Line([line.cells[place] for place in (0, *places)])
            for line in table.lines
            if line.cells[0].text.startswith(starts)
        ],
    )


def part_tables(name: str, subjects: Mapping[str, SubjectResults]) -> str:
    """Return the tables of a study part for each subject as Markdown, shortened to `EXCERPTS`."""
    made = {title: PARTS[name].made_tables(results) for title, results in subjects.items()}
    if name in EXCERPTS:
        made = {
            title: [excerpt(t, *e) for t, e in zip(whole, EXCERPTS[name], strict=False)]
            for title, whole in made.items()
        }
    several = sum(map(bool, made.values())) > 1
    texts = (captioned(*tables, title=title if several else "") for title, tables in made.items())
    return "\n".join(filter(None, texts))


def read_subjects(path: Path) -> dict[str, SubjectResults]:
    """Return the results of each subject of a study by its title."""
    named = named_subjects(read_study(path))
    return {name.replace("-", " "): results for name, results in named.items()}


def front_table(subjects: Mapping[str, SubjectResults]) -> Table:
    """Return the table of the README: a few results, each with values for comparison.

    Lines without results are left out.
    """
    by_model = {
        name: optional(lambda r, name=name: r[OBJECTS].get(name), lambda scores: scores.rmse)
        for name in ("cnn", "svm", "peak", "log_spectrum")
    }
    by_package = optional(lambda r: r[IN_FORCE], lambda scores: scores.rmse)
    ready = optional(lambda r: r[IN_FORCE], lambda scores: scores.share)
    ready_window = optional(lambda r: r[ANSWER], lambda times: times.before_second)
    entries = [
        ("Error for new objects", "paper rig", "one", by_package,
         [(by_model["cnn"], "with the paper's CNN"), (by_model["svm"], "with its SVM"),
          (by_model["peak"], "with the peak amplitude alone")]),
        ("Error for new objects in everyday conditions", "everyday", "one", by_package,
         [(by_model["log_spectrum"], "with a model of the log spectrum of 15 ms of signal")]),
        ("Pinches with an estimate before the second finger touches, everyday", "everyday", "whole",
         ready, [(ready_window, "if the model waits for 15 ms, as in the paper")]),
    ]  # fmt: skip
    lines = []
    for words, title, unit, value, yardsticks in entries:
        results = subjects.get(title)
        measures = (value, *(yardstick for yardstick, _ in yardsticks))
        cell, *others = [format_cell(f(results) if results else None, unit) for f in measures]
        if all(c.text != ABSENT for c in (cell, *others)):
            beside = (f"{c.text} {words}" for c, (_, words) in zip(others, yardsticks, strict=True))
            lines.append(Line([Cell(words), cell, Cell(", ".join(beside))]))
    return Table("", ["on the simulated hand", "result", "for comparison"], lines)


def study_tables(path: Path) -> dict[str, str]:
    """Return the tables of a study of the twin."""
    subjects = read_subjects(path)
    chosen = [row for name in PARTS if name != TIMED for row in rows(subjects, [name])]
    total = Row[SubjectResults]("The whole study", lambda results: results[SECONDS], "s")
    speed = [*rows(subjects, [TIMED]), total]
    return {
        "front": markdown(front_table(subjects)),
        "main": markdown(
            row_table([row for row in chosen if row.label in MAIN], subjects, published=True)
        ),
        "study": markdown(row_table(chosen, subjects, published=True)),
        "speed": markdown(row_table(speed, subjects, published=True)),
        **{name: made for name in PARTS if (made := part_tables(name, subjects))},
    }


def ratio_table(path: Path) -> str:
    """Return the ratios of all benchmarks and the machine that they ran on."""
    run = json.loads(path.read_text(encoding="utf-8"))
    rows = []
    for name, ratio in run["ratios"].items():
        program, what = name.split(": ", 1)
        rows.append((f"`benchmarks/{program}.py`", what, f"{ratio:.{0 if ratio >= 10 else 2}f}"))
    machine = f"{run['cores']} cores of {run['machine']}, {sum(run['seconds'].values()):.0f} s"
    return f"One run on {machine}:\n\n{markdown_table('program | what | times as fast', rows)}"


def tables(results: Path) -> dict[str, str]:
    """Return all tables by name, from the results that exist."""
    names = ("front", "main", "study", "speed", "real", "strikes", "sets", "noises", "drops")
    names = (*names, "grasp_headline", "grasp_short", "benchmarks")
    made = dict.fromkeys((*names, *GRASP, *PARTS), "*Not run yet.*\n")
    if (results / "study.json").is_file():
        made |= study_tables(results / "study.json")
    for file, name in (
        ("generalise", "structure"),
        ("random_rigs", "random_rigs"),
        ("closing_speed", "closing_speed"),
        ("continuum", "continuum"),
        ("whole_grasp", "whole_grasp"),
    ):
        if (results / f"{file}.json").is_file():
            made[name] = part_tables(name, read_subjects(results / f"{file}.json"))
    if (results / "real.json").is_file():
        subjects = {"here": read_study(results / "real.json").about}
        chosen = [row for name in PARTS if name != TIMED for row in rows(subjects, [name])]
        made["real"] = markdown(row_table(chosen, subjects))
    if (results / "strikes.json").is_file():
        subjects = {"here": read_study(results / "strikes.json").about}
        made["strikes"] = part_tables("short_windows", subjects) or made["strikes"]
    if (results / "grasp.json").is_file():
        household = read_study(results / "grasp.json").about[HOUSEHOLD]
        assert household is not None
        made["grasp_short"] = grasp_sentences.readme_sentences(household) + "\n"
        made["grasp_headline"] = "".join(
            f"- {sentence}\n" for sentence in grasp_sentences.sentences(household)
        )
        for name, make in GRASP.items():
            made[name] = captioned(make(household))
    if (results / "benchmarks.json").is_file():
        made["benchmarks"] = ratio_table(results / "benchmarks.json")
    if (results / "sets.json").is_file():
        subjects = named_subjects(read_study(results / "sets.json"))
        made["sets"] = markdown(overview(subjects))
        made["noises"] = (
            "\n".join(markdown(table) for table in noise_tables(subjects) if table)
            or made["noises"]
        )
        measured = [results for results in subjects.values() if results[STIFFNESS]]
        made["drops"] = part_tables("stiffness", {"drops": measured[0]}) if measured else "\n"
    return made


def copy(source: Path, name: str) -> None:
    """Copy results into the docs, without the paths of the machine that ran the study."""
    tree = to_tree(read_study(source))
    run = tree["study"]
    run.pop("asked", None)
    run["command"] = re.sub(r"(?<![^\s=])[^\s=]*/", "", run["command"])
    text = json.dumps(tree, indent=1, ensure_ascii=False) + "\n"
    (RESULTS / f"{name}.json").write_text(text, encoding="utf-8")


def filled(text: str, made: dict[str, str]) -> str:
    """Return a page with its tables in place. A name that no table has is a KeyError."""
    return fill(text, "numbers", made)


def pages(root: Path) -> list[Path]:
    """Return the pages with tables of results."""
    pages = (root / "README.md", *sorted(root.glob("docs/**/*.md")))
    return [page for page in pages if "<!-- numbers: " in page.read_text(encoding="utf-8")]


def main() -> None:
    """Copy the results that the options name, then write the tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--study", type=Path, help="results.json of `make study`")
    parser.add_argument("--generalise", type=Path, help="results.json of `make generalise`")
    parser.add_argument("--random-rigs", type=Path, help="results.json of that study part")
    parser.add_argument("--closing-speed", type=Path, help="results.json of that study part")
    parser.add_argument("--whole-grasp", type=Path, help="results.json of that study part")
    parser.add_argument("--continuum", type=Path, help="results.json of `make continuum`")
    parser.add_argument("--real", type=Path, help="results.json of the impacts of `make real`")
    parser.add_argument("--strikes", type=Path, help="results.json of its strikes")
    parser.add_argument("--sets", type=Path, help="results.json of `make real`")
    parser.add_argument(
        "--grasp", type=Path, help="results.json of `firstcontact grasp-study` and its picture"
    )
    options = parser.parse_args()
    RESULTS.mkdir(exist_ok=True)
    for name, source in (
        ("study", options.study),
        ("generalise", options.generalise),
        ("random_rigs", options.random_rigs),
        ("closing_speed", options.closing_speed),
        ("continuum", options.continuum),
        ("whole_grasp", options.whole_grasp),
        ("real", options.real),
        ("strikes", options.strikes),
        ("grasp", options.grasp),
        ("sets", options.sets),
    ):
        if source is not None:
            copy(source, name)
    if options.grasp is not None:
        shutil.copy(options.grasp.with_name("grasp.png"), ROOT / "docs/images")
    if options.sets is not None:
        curves = stiffness_curves(named_subjects(read_study(RESULTS / "sets.json")))
        if curves is not None:
            image = b64decode(curves.image.partition(",")[2])
            (ROOT / "docs/images/stiffness-over-time.svg").write_bytes(image)
    made = tables(RESULTS)
    for page in pages(ROOT):
        text = page.read_text(encoding="utf-8")
        if (new := filled(text, made)) != text:
            page.write_text(new, encoding="utf-8")
            print(f"wrote {page.relative_to(ROOT)}")


if __name__ == "__main__":
    main()
