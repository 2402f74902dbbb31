"""Study part ``generalise``: scores beyond the training blocks.

They are scores on unseen objects, on another hand, and on a Shore A that was left out.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial

from firstcontact.core.display import INK
from firstcontact.core.installation import missing_modules
from firstcontact.jobs import Runner
from firstcontact.models import ESTIMATORS, Task
from firstcontact.models.registry import window_estimators
from firstcontact.twin import CONDITIONS
from firstcontact_lab.report import names
from firstcontact_lab.report.findings import Figure, PartResult
from firstcontact_lab.report.names import NETWORK_COLOUR, NETWORK_TITLES, competitor_title
from firstcontact_lab.report.results import Field, SubjectResults
from firstcontact_lab.report.style import canvas, uri
from firstcontact_lab.report.tables import ABSENT, Cell, Line, Table, bounded, format_cell
from firstcontact_lab.study.comparison import (
    BRIEF,
    MASKED,
    NETWORK,
    Competitor,
    Generalised,
    compared,
    rig_sets,
)
from firstcontact_lab.study.detection_scores import outcome
from firstcontact_lab.study.off_blocks import OffBlocks
from firstcontact_lab.study.part import Part, Step, StudySettings, Subject
from firstcontact_lab.study.rig_sets import Sizes

#: Number of sets on which estimators that train slowly are scored. Their training is brief.
SLOW_SETS = 1


def generalise(subject: Subject, settings: StudySettings, runner: Runner) -> PartResult:
    if subject.name not in CONDITIONS:
        return PartResult()
    sizes = BRIEF if settings.brief else Sizes()
    late = _contact_delays(subject, settings.early)
    seeds = settings.rig_seeds
    sets = rig_sets(seeds, CONDITIONS[subject.name], sizes, late, runner)
    results = compared(partial(_competitors, settings), sets, seeds, settings.seed, runner)
    return PartResult([GENERALISE(results)], [generalise_figure(results)])


def _competitors(settings: StudySettings, place: int) -> list[Competitor]:
    out = []
    for name, entry in window_estimators().items():
        if entry.baseline or Task.REGRESSION not in entry.tasks or missing_modules(entry.modules):
            continue
        if entry.slow and (settings.brief or place >= SLOW_SETS):
            continue
        options = entry.quick if entry.slow or settings.brief else {}
        out.append(Competitor(name, "window", {"estimator": name, **options}))
    return [*out, MASKED, *NETWORK]


def _contact_delays(subject: Subject, early: float) -> list[int]:
    """Return the delay of each correctly detected contact after the true contact, in samples."""
    pairs = zip(subject.dataset.pinches, subject.starts, strict=True)
    late = [
        contact.sample - pinch.first.sample
        for pinch, contact in pairs
        if contact is not None
        and pinch.first is not None
        and outcome(contact, pinch.first, pinch.layout.rate, early) == "success"
    ]
    return late or [0]


_PANELS = {
    "objects": "Unseen objects",
    "three_pinches": "Three pinches",
    "other_hand": "Another hand",
    "level_left_out": "Hardness left out",
}


def generalise_figure(generalised: Generalised) -> Figure:
    rows = list(generalised.estimators)
    rigs = "1 rig" if generalised.sets == 1 else f"{generalised.sets} rigs"
    size = (6.2, 1.4 + 0.46 * len(rows))
    with canvas(2, 2, size, sharex=True, sharey=True) as (figure, axes):
        for ax, (key, title) in zip(axes.flat, _PANELS.items(), strict=True):
            for at, name in enumerate(rows):
                score = bounded(generalised.estimators[name], key)
                if score is None:
                    continue
                colour = NETWORK_COLOUR if name in NETWORK_TITLES else names.estimator(name).colour
                if score.ends is not None:
                    ax.plot(score.ends, (at, at), color=colour, lw=3, alpha=0.35)
                ax.plot(score.value, at, "o", color=colour, ms=5)
            references = {"floor": generalised.floor, **generalised.ceiling}
            for (name, reference), style in zip(references.items(), ("--", ":", "-."), strict=True):
                score = bounded(reference, key)
                if score is not None:
                    label = competitor_title(name)
                    ax.axvline(score.value, color=INK, ls=style, lw=1.0, label=label)
            ax.set(title=title)
        axes[0, 0].set_yticks(range(len(rows)), [competitor_title(name) for name in rows])
        axes[0, 0].set(xlim=(0, None), ylim=(len(rows) - 0.5, -0.5))
        for ax in axes[-1]:
            ax.set_xlabel("RMSE (Shore A)")
        figure.legend(*axes[0, 0].get_legend_handles_labels(), loc="outside lower center", ncols=3)
        image = uri(figure)
    return Figure(
        "generalise",
        "Errors off the blocks",
        f"{rigs}, each with another hand and other specimens; bars are 95 % bootstrap intervals "
        "over rigs. Lines are estimators with more information: other specimens of these kinds on "
        "the same rig, the modulus, or the contact's stiffness.",
        image,
    )


GENERALISE = Field.optional("generalise", Generalised)
_OBJECTS = {
    "objects": ("Unseen objects", "shore"),
    "three_pinches": ("Three pinches", "shore"),
    "bias": ("Bias", "bias"),
    "bias_softest": ("Bias, softest", "bias"),
    "bias_hardest": ("Bias, hardest", "bias"),
}
_OTHERS = {
    "other_hand": ("Another hand", "shore"),
    "bias_other_hand": ("Bias there", "bias"),
    "level_left_out": ("Hardness left out", "shore"),
    "blocks": ("Blocks", "shore"),
    "accuracy": ("Nearest level", "share"),
}


def objects_off_blocks(results: SubjectResults) -> Table | None:
    return _table(results[GENERALISE], _OBJECTS, "Unseen objects: RMSE and bias")


def others_off_blocks(results: SubjectResults) -> Table | None:
    return _table(results[GENERALISE], _OTHERS, "Other hands, levels and sessions: RMSE")


def _table(
    generalised: Generalised | None, columns: Mapping[str, tuple[str, str]], title: str
) -> Table | None:
    if generalised is None:
        return None
    rigs = "1 rig" if generalised.sets == 1 else f"{generalised.sets} rigs"
    seeds = ", ".join(map(str, generalised.seeds))
    default = names.estimator(ESTIMATORS.default).title
    caption = (
        f"{title} in Shore A over {rigs} (seeds {seeds}), one pinch. After each value: "
        f"its 95 % bootstrap interval over rigs, and its ratio to the error of {default}."
    )
    usual = generalised.estimators.get(ESTIMATORS.default)
    learned = "other specimens, same rig"
    entries = [
        (Cell(competitor_title(n), _remark(e, generalised.sets)), e, False)
        for n, e in generalised.estimators.items()
    ]
    entries.append((Cell(competitor_title("floor"), learned), generalised.floor, False))
    entries += [(Cell(competitor_title(n)), e, True) for n, e in generalised.ceiling.items()]
    lines = []
    for name, scores, quiet in entries:
        base = None if quiet or scores is usual else usual
        cells = [_cell(scores, key, unit, base) for key, (_, unit) in columns.items()]
        if any(cell.text != ABSENT for cell in cells):
            lines.append(Line([name, *cells], quiet))
    return Table(caption, ["", *(head for head, _ in columns.values())], lines)


def _remark(scores: OffBlocks, sets: int) -> str:
    """Return text on options that differ from the defaults, and on rigs without scores.

    Return "" if there are none.
    """
    options = [f"{key} {value}" for key, value in (scores.options or {}).items()]
    return ", ".join([*options, f"{scores.sets} of {sets} rigs"] if scores.sets < sets else options)


def _cell(scores: OffBlocks, key: str, unit: str, usual: OffBlocks | None) -> Cell:
    score = bounded(scores, key)
    cell = format_cell(score, unit)
    base = bounded(usual, key) if usual is not None and scores.sets == usual.sets else None
    if score is None or base is None or unit != "shore" or base.value <= 0:
        return cell
    ratio = f"× {score.value / base.value:.2f}"
    return Cell(cell.text, f"{cell.small}; {ratio}" if cell.small else ratio)


PART = Part(
    "generalise",
    "Beyond the blocks",
    [Step("beyond the blocks", generalise, late=True, cost=100)],
    lambda subjects: (
        "Hands, objects and sessions on which nothing in this project was chosen. All estimators "
        "learn from the same block pinches. They predict at the same contacts: the known contacts, "
        "with the delays of the detector above. Three pinches: the mean of three estimates of "
        "one object. Another hand: the estimators learn from 30 block pinches of that hand. "
        "Hardness left out: one of 20, 29 and 43 Shore A is missing in training, and is predicted. "
        "Pale rows use information that is not in the signal: the object's modulus, so that "
        "only the label's error is left, or the stiffness of the contact."
    ),
    [objects_off_blocks, others_off_blocks],
    by_default=False,
)
