"""Benchmark of any regressor, the default estimator and the network, on the same pinches.

The pinches come from simulated rigs, or from recordings with whole sessions held out.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import Contact, Dataset, InputError, Record
from firstcontact.core.jobs import Runner
from firstcontact.core.text import counted, percent
from firstcontact.models import ESTIMATORS, LabelledTouches, Predictions
from firstcontact.models.alignment import choose_detector, detect_alignment
from firstcontact.models.model_file import pretrained
from firstcontact.models.scores import CLUSTERS
from firstcontact.models.splits import Split, by_session
from firstcontact.recording import load_dataset
from firstcontact.recording.settings import check_rate
from firstcontact.signal import resample_dataset
from firstcontact.twin.draw import condition
from firstcontact_lab.report.findings import PartResult, State
from firstcontact_lab.report.names import competitor_title
from firstcontact_lab.report.page import Page
from firstcontact_lab.report.results import Field, SubjectResults
from firstcontact_lab.report.run import Job, run_steps
from firstcontact_lab.report.tables import Bounded, Cell, Line, Table, format_cell, plain_lines
from firstcontact_lab.study._comparison import (
    BRIEF,
    HOME,
    NETWORK,
    Competitor,
    Generalised,
    compared,
    fit_on_set,
    fit_predictor,
    rig_sets,
    sides,
)
from firstcontact_lab.study._rig_sets import RigSet, Sizes, Use
from firstcontact_lab.study.part import Part, StudySettings, Subject, Subjects
from firstcontact_lab.study.parts.generalise import GENERALISE, PART, generalise_figure
from firstcontact_lab.study.parts.objects import why_not_unseen
from firstcontact_lab.study.scores import (
    AnytimeScores,
    anytime_scores,
    join_by_time,
    learns_one_value,
    predictions_by_time,
)

#: Delays of the contacts in samples, drawn at random: about those of detectors on the twin.
LATE = (0, 0, 1, 1, 1, 2, 2, 2, 3, 3, 4)

Names = NDArray[np.str_]


@dataclass(frozen=True, slots=True)
class BenchmarkSize:
    seeds: tuple[int, ...] = StudySettings().rig_seeds
    sizes: Sizes = field(default_factory=Sizes)


#: Size of a quick benchmark.
QUICK = BenchmarkSize((StudySettings().rig_seeds[0],), BRIEF)


class Benchmarked(Record, frozen=True, kw_only=True):
    generalise: Generalised
    anytime: dict[str, AnytimeScores]


class RecordedScores(Record, frozen=True, kw_only=True):
    learned: float
    folds: int
    cluster: str
    clusters: int
    scores: dict[str, AnytimeScores]


class RecordedData(Record, frozen=True, kw_only=True):
    path: str
    source: str
    pinches: int
    unused: int
    too_short: int
    levels: list[float]
    contacts: str
    detector: str = ""
    held_out: RecordedScores
    objects: RecordedScores | None = None
    left_out: str = ""


BENCHMARK = Field.optional("benchmark", dict[str, AnytimeScores])
RECORDINGS = Field.optional("recordings", RecordedData)


def run_benchmark(
    name: str,
    out: Path,
    recordings: Path | None,
    conditions: Sequence[str],
    quick: bool,
    seed: int,
    workers: int,
) -> list[str]:
    """Compare a regressor with the package's estimators; return the tables as lines of text."""
    state = State(
        settings={"regressor": name, "seed": seed},
        options={"verb": "benchmark"},
        parts={"benchmark": BENCHMARK_PART, "generalise": replace(PART, text=lambda subjects: "")},
        page=partial(_page, name),
        quick=quick,
    )

    def jobs(runner: Runner) -> list[Job]:
        if recordings is not None:
            measure = partial(_recorded, name, recordings, seed, runner)
            return [Job("recordings", "benchmark", "benchmark", measure, vital=True)]
        size = QUICK if quick else BenchmarkSize()
        return [
            Job(
                of,
                "benchmark",
                "benchmark",
                partial(_simulated, name, of, size, seed, runner),
                True,
            )
            for of in conditions
        ]

    run_steps(out, state, workers, jobs)
    lines = []
    for findings in state.findings:
        subjects = {findings.title: findings.results}
        for part in state.parts.values():
            for table in part.made_tables(findings.results):
                lines += ["", findings.title, part.text(subjects), table.caption]
                lines += plain_lines(table, small=True)
    return lines


def _simulated(name: str, of: str, size: BenchmarkSize, seed: int, runner: Runner) -> PartResult:
    scores = benchmark(name, of, size, seed, runner)
    figure = generalise_figure(scores.generalise)
    return PartResult([GENERALISE(scores.generalise), BENCHMARK(scores.anytime)], [figure])


def _recorded(name: str, path: Path, seed: int, runner: Runner) -> PartResult:
    dataset = _load(path)
    data = benchmark_recordings(name, dataset, path, seed, runner)
    left_out = [*dataset.losses, *([data.left_out] if data.left_out else [])]
    return PartResult([RECORDINGS(data)], left_out=left_out)


def named_competitor(name: str) -> Competitor:
    """Return the competitor with a name: a registered estimator, or ``PACKAGE:NAME``."""
    ESTIMATORS.find(name)
    if ":" in name:
        return Competitor(name, "any time", {"regressor": name})
    return Competitor(name, "window", {"estimator": name})


def all_competitors(name: str) -> list[Competitor]:
    """Return the named competitor, the default estimator, and the network's variants."""
    query, usual = named_competitor(name), named_competitor(ESTIMATORS.default)
    return [query, *([] if query == usual else [usual]), *NETWORK]


def benchmark(
    name: str, condition_name: str, size: BenchmarkSize, seed: int, runner: Runner
) -> Benchmarked:
    """Compare an estimator with the default estimator and the network in a twin condition."""
    competitors = all_competitors(name)
    sets = rig_sets(size.seeds, condition(condition_name), size.sizes, LATE, runner)
    generalised = compared(lambda place: competitors, sets, size.seeds, seed, runner)
    timed = competitors[:-1]  # the radius is not given by time
    places = range(len(sets))
    jobs = [(competitor, place) for competitor in timed for place in places]
    answers = iter(runner.map(_timed, jobs, sets, seed))
    objects = [rigs.windows.take(rigs.indices(Use.OBJECTS)) for rigs in sets]
    truth = np.concatenate([windows.y for windows in objects])
    # An object has much of its error on all rigs: the rigs together have only as many clusters.
    names = np.concatenate([windows.objects for windows in objects])
    scores = {
        competitor.name: anytime_scores(
            join_by_time([next(answers) for _ in places]), truth, names, seed
        )
        for competitor in timed
    }
    return Benchmarked(generalise=generalised, anytime=scores)


def _timed(
    query: tuple[Competitor, int], sets: Sequence[RigSet], seed: int
) -> dict[int, Predictions]:
    competitor, place = query
    rigs = sets[place]
    model = fit_on_set(competitor, rigs, sides(rigs, HOME)[0], seed)
    return predictions_by_time(model, rigs.touches.take(rigs.indices(Use.OBJECTS)))


def benchmark_recordings(
    name: str, dataset: Dataset, path: Path, seed: int, runner: Runner
) -> RecordedData:
    """Score a regressor, the default estimator and the network on the same folds."""
    competitors = all_competitors(name)[:-1]
    contacts, how, chosen = _contacts(dataset, seed, runner)
    labelled = LabelledTouches.cut(dataset, contacts)
    scored = labelled.take(labelled.touches.answerable)
    test = dataset.test[scored.rows]
    learn, ask = np.flatnonzero(~test), np.flatnonzero(test)
    cluster, groups = _groups(dataset, scored, learn, path)
    folds = [
        replace(fold, train=learn[fold.train], test=learn[fold.test])
        for fold in by_session(groups[learn], scored.shore_a[learn], seed)
    ]
    if learns_one_value(folds, scored.shore_a):
        raise InputError(
            f"{path}: if some {cluster}s are held out, fewer than two Shore A levels are left for "
            f"training: record each level in several {cluster}s, or more levels"
        )
    reason = why_not_unseen(Subject("recordings", dataset)) if dataset.test.any() else ""
    if dataset.test.any() and not (reason or len(ask)):
        reason = "Unseen objects: no contact was found in them."

    def scores(splits: Sequence[Split], clusters: Names, cluster: str) -> RecordedScores:
        return _scores(competitors, scored, splits, groups, clusters, cluster, seed, runner)

    try:
        held_out = scores(folds, groups, cluster)
        split = Split("unseen objects", learn, ask)
        has_objects = len(ask) and not reason
        objects = scores([split], scored.clusters, "specimen") if has_objects else None
    except InputError as error:
        raise InputError(f"{path}: {error}") from error
    return RecordedData(
        path=str(path),
        source=dataset.source,
        pinches=len(dataset),
        unused=len(dataset) - len(labelled),
        too_short=len(labelled) - len(scored),
        levels=[float(level) for level in np.unique(scored.shore_a[learn])],
        contacts=how,
        detector=chosen,
        held_out=held_out,
        objects=objects,
        left_out=reason,
    )


def _load(path: Path) -> Dataset:
    """Return the pinches of recordings, resampled to the network's rate."""
    dataset = load_dataset(path)
    if dataset.test.all():
        raise InputError(f'{path}: all pinches have role "test": record training pinches')
    if not np.isfinite(dataset.shore_a[~dataset.test]).any():
        raise InputError(
            f"{path}: no training pinch has a Shore A: record with --shore-a, or import with a "
            "column 'shore_a'"
        )
    check_rate(f"{path}: the rate", dataset.layout.rate)
    return resample_dataset(dataset, pretrained().rate)


def _contacts(
    dataset: Dataset, seed: int, runner: Runner
) -> tuple[Sequence[Contact | None], str, str]:
    """Return the first contact of each pinch, how it was detected, and by which detector."""
    contacts: list[Contact | None] = [None] * len(dataset)
    learn = dataset.take(~dataset.test)
    detector, alignment, reason = choose_detector(
        learn, name=None, is_known=False, seed=seed, runner=runner
    )
    parts = [(~dataset.test, alignment.contacts)]
    if dataset.test.any():
        objects = detect_alignment(dataset.take(dataset.test), detector)
        parts.append((dataset.test, objects.contacts))
    for mask, part in parts:
        for place, contact in zip(np.flatnonzero(mask), part, strict=True):
            contacts[place] = contact
    return contacts, alignment.how, reason


def _groups(
    dataset: Dataset, labelled: LabelledTouches, learn: NDArray[np.intp], path: Path
) -> tuple[str, Names]:
    """Return "session" or "specimen", and the session or specimen of each pinch."""
    if labelled.take(learn).named_sessions is not None:
        return "session", labelled.sessions
    specimens = [dataset.pinches[place].label.specimen for place in labelled.rows[learn]]
    if len(set(specimens)) < 2 or "" in specimens:
        raise InputError(
            f"{path}: contacts with a Shore A are all of one session and one specimen (or have no "
            "names), so none can be held out: record two sessions or more"
        )
    return "specimen", labelled.specimens


def _scores(
    competitors: Sequence[Competitor],
    labelled: LabelledTouches,
    splits: Sequence[Split],
    groups: Names,
    clusters: Names,
    cluster: str,
    seed: int,
    runner: Runner,
) -> RecordedScores:
    """Return the scores of all competitors on the test sides of the same splits."""
    trainings = [(competitor, split) for competitor in competitors for split in splits]
    answers = iter(runner.map(_predict, trainings, labelled, groups, seed))
    order = np.concatenate([split.test for split in splits])
    truth = labelled.shore_a[order]
    return RecordedScores(
        learned=float(np.mean([len(split.train) for split in splits])),
        folds=len(splits),
        cluster=cluster,
        clusters=len(np.unique(clusters[order])),
        scores={
            competitor.name: anytime_scores(
                join_by_time([next(answers) for _ in splits]), truth, clusters[order], seed
            )
            for competitor in competitors
        },
    )


def _predict(
    training: tuple[Competitor, Split], labelled: LabelledTouches, groups: Names, seed: int
) -> dict[int, Predictions]:
    competitor, split = training
    train, test = labelled.take(split.train), labelled.take(split.test)
    model = fit_predictor(competitor, train.touches, train.shore_a, groups[split.train], seed)
    return predictions_by_time(model, test.touches)


def by_time(results: Mapping[str, AnytimeScores], caption: str) -> Table:
    """Return a table of all competitors: errors, and coverage and width of intervals by time."""
    times = list(next(iter(results.values())).rmse)
    lines = []
    for name, scores in results.items():
        ends = scores.intervals.get("rmse", {})
        errors = [format_cell(Bounded(scores.rmse[ms], ends.get(ms)), "shore") for ms in times]
        shares = [
            Cell(f"{percent(scores.coverage[ms], 0)} in ±{scores.width[ms] / 2:.1f}")
            for ms in times
        ]
        lines.append(Line([Cell(competitor_title(name), counted(scores.n, "pinch")), *errors]))
        lines.append(Line([Cell("90 % interval"), *shares]))
    caption += (
        " First rows: RMSE in Shore A. Second rows: share of truths in the 90 % interval, and half "
        "its mean width. Estimators with a fixed window have one model for each length. Signal "
        "from the second finger's contact on is left out."
    )
    return Table(caption, ["", *(f"{ms} ms" for ms in times)], lines)


def _tables(results: SubjectResults) -> list[Table]:
    caption = (
        "Unseen objects by the time after the contact. In brackets: 95 % bootstrap interval over "
        "objects; a specimen of each on every rig."
    )
    scores, data = results[BENCHMARK], results[RECORDINGS]
    made = [by_time(scores, caption)] if scores else []
    groups = _groups_of(data) if data else []
    return [*made, *(by_time(group.scores, _caption(title, group)) for title, group in groups)]


def _groups_of(data: RecordedData) -> list[tuple[str, RecordedScores]]:
    groups = [(f"Held-out {data.held_out.cluster}s", data.held_out)]
    return groups if data.objects is None else [*groups, ("Unseen objects", data.objects)]


def _caption(title: str, scores: RecordedScores) -> str:
    """Return sentences on training data and folds, and on what the intervals resample."""
    if title == "Unseen objects":
        text = 'Pinches of role "test". Models learn from all pinches of role "train", '
        text += f"{scores.learned:,.0f} in number."
    else:
        text = f'Pinches of role "train". Each of {scores.folds} folds holds out whole '
        text += f"{scores.cluster}s and trains on the others, {scores.learned:,.0f} pinches on "
        text += "average."
        if scores.cluster == "session":
            text += " The same specimens may be in other sessions."
    if scores.clusters < CLUSTERS:
        few = counted(scores.clusters, scores.cluster)
        intervals = f"There is no bootstrap interval: {few} are too few, at least {CLUSTERS} are "
        return f"{title}. {text} {intervals}needed."
    interval = f"In brackets: 95 % bootstrap interval over {scores.clusters} {scores.cluster}s."
    return f"{title}. {text} {interval}"


#: Opening words by the source of recordings.
_SOURCES = {
    "twin": "Twin results, on recordings of simulated pinches",
    "real": "Results on real recordings",
    "synthetic": "Results on synthetic recordings",
}


def _text(subjects: Subjects) -> str:
    data = next((results[RECORDINGS] for results in subjects.values()), None)
    if data is None:
        return (
            "Twin results: contacts of simulated rigs. Hands and specimens have other seeds "
            "than in any training."
        )
    levels = ", ".join(f"{level:g}" for level in data.levels)
    chosen = f" {data.detector[0].upper()}{data.detector[1:]}." if data.detector else ""
    return (
        f"{_SOURCES.get(data.source, 'Recordings')}: {data.path}, "
        f"{counted(data.pinches, 'pinch')}, Shore A {levels} to learn from. "
        f"Contacts: {data.contacts}.{chosen} "
        f"Not scored: {counted(data.unused, 'pinch')} without contact or Shore A, "
        f"{data.too_short:,} whose second contact came before any estimate."
    )


BENCHMARK_PART = Part("benchmark", "By the time after the contact", text=_text, tables=_tables)


def _page(name: str, state: State) -> Page:
    return Page(
        title=f"Benchmark of {name}",
        heading=f"Benchmark of {name}",
        intro="A regressor, the default estimator and the network on the same pinches.",
        badges=["Benchmark", f"seed {state.settings['seed']}", state.elapsed],
        warning="Quick benchmark: do not quote its numbers",
        how=[("Seed", [str(state.settings["seed"])]), ("Time", [state.elapsed])],
        several=len(state.findings) > 1,
    )
