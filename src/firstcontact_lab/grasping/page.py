"""Report page of the grasp study, made from its results."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from statistics import median
from typing import TYPE_CHECKING, TypeVar

import numpy as np

from firstcontact.core.display import GREY, INK
from firstcontact.grasp import POLICIES
from firstcontact.grasp.policy import PolicyRole, Task
from firstcontact_lab.grasping.judgement import baseline, candidate
from firstcontact_lab.grasping.results import (
    CEILING,
    FIRMEST,
    USED,
    Between,
    FrontPoints,
    Household,
    ObjectErrors,
)
from firstcontact_lab.grasping.sentences import percent, policy_title, sentences
from firstcontact_lab.report.findings import Figure
from firstcontact_lab.report.page import Page, State
from firstcontact_lab.report.results import Field, SubjectResults
from firstcontact_lab.report.style import canvas, uri
from firstcontact_lab.report.tables import (
    Cell,
    Line,
    Row,
    Table,
    Value,
    bounded,
    format_cell,
    matrix,
)
from firstcontact_lab.study.part import Part

if TYPE_CHECKING:
    from matplotlib.axes import Axes

T = TypeVar("T")

HOUSEHOLD = Field.optional("household", Household)

#: Approximate Shore A of the firmest object in the training of the network.
MET = 80.0
CONTROLS = {
    "mass_permuted": "Weights of other objects",
    "damage_permuted": "Damage limits of other objects",
    "both_permuted": "Both (must be 0 within its interval)",
}
#: Size of the figure as a separate picture and in the report, inch.
SIZE = (7.4, 4.6)
#: Largest share of drops and of damage in the figure, %.
MOST_DAMAGE, MOST_DROPS = 40.0, 60.0
#: Distance below which two points are drawn side by side, %.
APART = 0.35


def fronts_picture(household: Household, image: Path) -> None:
    with canvas(size=SIZE) as (figure, axes):
        _draw_fronts(axes[0, 0], household)
        figure.savefig(image, format="png", dpi=150, metadata={"Software": None})


def _draw_fronts(axis: Axes, household: Household) -> None:
    percent = 100 * household.damage
    axis.axvline(percent, color=GREY, linewidth=0.9, linestyle=":")
    axis.text(percent + 1.0, MOST_DROPS, "a tenth damaged", va="top", fontsize=8, color="#52606D")
    lines = {
        name: policy
        for name, policy in POLICIES.items()
        if policy.task is Task.HOUSEHOLD and name in household.fronts
    }
    for place, (name, policy) in enumerate(lines.items()):
        line = "--" if policy.has_reflex() else ":" if policy.part is PolicyRole.LIMIT else "-"
        _draw_front(axis, household.fronts[name], policy.colour, line, policy.title)
        between = household.drops_between[name]
        axis.errorbar(
            percent + APART * (place - (len(lines) - 1) / 2), 100 * between.value,
            yerr=[
                [100 * max(between.value - between.low, 0)],
                [100 * max(between.high - between.value, 0)],
            ],
            color=policy.colour, marker="o", markersize=5, capsize=3, linewidth=1.1, zorder=3,
        )  # fmt: skip
    if CEILING in household.fronts:
        _draw_front(axis, household.fronts[CEILING], INK, "*-.", "ceiling: each specimen known")
    axis.set_xlim(0, MOST_DAMAGE)
    axis.set_ylim(0, MOST_DROPS)
    axis.set_xlabel("Damaged (% of closings)")
    axis.set_ylabel("Dropped (% of closings)")
    axis.text(0.6, 0.6, "better", va="bottom", fontsize=8, color="#52606D")
    axis.legend(loc="upper right")


def _draw_front(axis: Axes, points: FrontPoints, colour: str, line: str, title: str) -> None:
    damaged = np.maximum.accumulate(100 * np.array(points.damaged))
    axis.plot(
        damaged, 100 * np.array(points.dropped), line, color=colour, label=title, linewidth=1.8
    )


def _table(caption: str, titles: Mapping[str, str], rows: Sequence[Row[str]]) -> Table:
    """Return a table with one line per key of ``titles`` and one column per entry of ``rows``."""
    lines = [(Cell(title), key, False) for key, title in titles.items()]
    return matrix(caption, rows, lines) or Table(caption, [""], [])


def _record_values(records: Mapping[str, T], value: Callable[[T], Value]) -> Callable[[str], Value]:
    """Return a function that maps a name to ``value`` of the record with this name.

    It maps a name without a record to None.
    """
    return lambda name: value(records[name]) if name in records else None


def policies_table(household: Household) -> Table:
    def drops(name: str) -> Value:
        between = household.drops_between.get(name)
        return household.drops_at_10_damage[name] if between is None else between.bounded

    return _table(
        "Share of objects that each policy drops. For a fair comparison, the forces of each policy "
        f"are scaled until {percent(household.damage)} of the objects are damaged; in the last "
        "column they are not scaled. Brackets hold 95 % intervals over hands and kinds of object. "
        "In rows with a label, the policy gets the true Shore A instead of the estimate, with or "
        "without a random error. In rows with a reflex the hand lifts gradually, and a slip is "
        "detected after 100 ms. The ceiling has the best force for each single specimen.",
        {name: policy_title(name) for name in household.drops_at_10_damage},
        [
            Row("Dropped", drops, "whole"),
            Row("Fewer than blind", _record_values(household.fewer, lambda b: b.bounded), "whole"),
            Row("Neither dropped nor damaged", household.success.__getitem__, "whole"),
        ],
    )


def reflex_table(household: Household) -> Table:
    reflexes = household.slip_reflex
    return _table(
        "Share of objects that a hand with a slip reflex drops, without and with an estimate of "
        "stiffness, at equal damage. Success means neither dropped nor damaged. Rows state how "
        "the support disappears (abrupt, or gradual within a second), and how long the "
        "detection of a slip takes. Then the brake needs 20 ms, and the force must build up.",
        {name: name for name in reflexes},
        [
            Row("Reflex alone", _record_values(reflexes, lambda r: r.blind.bounded), "whole"),
            Row("Stiffness, too", _record_values(reflexes, lambda r: r.stiffness.bounded), "whole"),
            Row("Fewer", _record_values(reflexes, lambda r: r.fewer.bounded), "whole"),
            Row("Success, alone", _record_values(reflexes, lambda r: r.success.blind), "whole"),
            Row("Success, both", _record_values(reflexes, lambda r: r.success.stiffness), "whole"),
        ],
    )


def _gains(
    caption: str, gains: Mapping[str, Between], unit: str, titles: Mapping[str, str]
) -> Table:
    row = Row[str]("Fewer drops than blind", _record_values(gains, lambda b: b.bounded), unit)
    return _table(caption, titles, [row])


def controls_table(household: Household) -> Table:
    return _gains(
        "Reduction of drops if each object gets the weight or the damage limit of another object, "
        "drawn at random. Stiffness then says nothing about it. Both policies are tuned again. "
        "Mean and middle 95 % of the random draws.",
        household.controls,
        "gain",
        {name: CONTROLS.get(name, name) for name in household.controls},
    )


def sensitivity_table(household: Household) -> Table:
    return _gains(
        "Reduction of drops by stiffness, if the estimated numbers of the household objects were "
        "different. Both policies are tuned again. Brackets of the last row hold the smallest and "
        "the largest value of its draws.",
        household.sensitivity,
        "whole",
        {name: name[0].upper() + name[1:] for name in household.sensitivity},
    )


def closings_table(household: Household) -> Table:
    closings = household.closings
    return _table(
        "Closings that are simulated in full at the tuned settings, with the live estimates and "
        "their deadline. Steady: share with a constant force, a quarter above the holding force. "
        "As tabulated: share with the outcome that the table of closings, used for tuning, "
        "predicts.",
        {name: policy_title(name) for name in closings},
        [
            Row("Success", _record_values(closings, lambda c: bounded(c, "success")), "whole"),
            Row("Dropped", _record_values(closings, lambda c: bounded(c, "dropped")), "whole"),
            Row("Damaged", _record_values(closings, lambda c: bounded(c, "damaged")), "whole"),
            Row("Steady", _record_values(closings, lambda c: c.steady), "whole"),
            Row(
                "Time to a steady grasp",
                _record_values(closings, lambda c: c.steady_ms),
                "whole ms",
            ),
            Row("Estimate by the deadline", _record_values(closings, lambda c: c.in_time), "whole"),
            Row("As tabulated", _record_values(closings, lambda c: c.as_table), "whole"),
        ],
    )


def _window_title(window: str) -> str:
    return window if window == USED else f"{window} ms"


def estimates_table(household: Household) -> Table:
    estimates = household.estimates
    lines = [
        Line([Cell(title), *(format_cell(values.get(w), unit) for w in estimates.rmse)])
        for title, values, unit in (
            ("RMSE, all objects (Shore A)", estimates.rmse, "one"),
            (f"RMSE, objects up to {FIRMEST:g} Shore A", estimates.bearing, "one"),
            ("Window complete before the second contact", estimates.decided, "whole"),
        )
    ]
    return Table(
        f"Errors of the estimates by time after the contact, and of the used ones. "
        f"{_firm_objects_sentence(household)}On held-out pinches of the hands' own blocks the "
        f"RMSE is {estimates.block_rmse:.1f}. "
        f"{percent(estimates.unanswered)} of pinches had no estimate before the second contact, "
        f"and {percent(estimates.heard)} of second contacts were detected.",
        ("", *map(_window_title, estimates.rmse)),
        lines,
    )


def _firm_objects_sentence(household: Household) -> str:
    """Return a sentence about estimates of objects firmer than all blocks.

    Return "" if there are no such objects.
    """
    answered = [entry for entry in household.by_object.values() if entry.bias is not None]
    firm = [entry for entry in answered if entry.shore_a > MET]
    if not firm:
        return ""
    labels = [entry.shore_a for entry in firm]
    read = median(entry.shore_a + (entry.bias or 0.0) for entry in firm)
    part, total = (sum(e.answered * e.rmse[USED] ** 2 for e in of) for of in (firm, answered))
    return (
        f"The network was not trained on objects much firmer than {MET:g} Shore A. For {len(firm)} "
        f"objects of {min(labels):g} to {max(labels):g} the median prediction is {read:.0f}. They "
        f"contribute {percent(part / total)} of the squared error. "
    )


def objects_table(household: Household) -> Table:
    objects = household.by_object

    def outcome(policy: str) -> Callable[[ObjectErrors], Value]:
        return lambda o: f"{percent(o.drops[policy])} / {percent(o.damage[policy])}"

    def error(window: str) -> Callable[[ObjectErrors], Value]:
        return lambda o: o.rmse.get(window)

    return _table(
        "By object: RMSE for each window, mean error of the estimates that were used, and the "
        "shares dropped / damaged with settings tuned without the object's family.",
        {name: name for name in objects},
        [
            Row("Shore A", _record_values(objects, lambda o: f"{o.shore_a:g}")),
            *(
                Row(_window_title(w), _record_values(objects, error(w)))
                for w in household.estimates.rmse
            ),
            Row("Mean error", _record_values(objects, lambda o: o.bias), "bias"),
            *(
                Row(p.title, _record_values(objects, outcome(p.name)))
                for p in (baseline(), candidate())
            ),
        ],
    )


def household_tables(results: SubjectResults) -> list[Table]:
    household = results[HOUSEHOLD]
    if household is None:
        return []
    return [
        policies_table(household),
        reflex_table(household),
        controls_table(household),
        closings_table(household),
        estimates_table(household),
        sensitivity_table(household),
        objects_table(household),
    ]


def fronts_figure(household: Household) -> Figure:
    with canvas(size=SIZE) as (figure, axes):
        _draw_fronts(axes[0, 0], household)
        image = uri(figure)
    return Figure(
        "fronts",
        "Dropped and damaged objects, from cautious to bold",
        f"Each line is one policy from cautious (left) to bold, on {household.picks} pinches of "
        f"{household.objects} objects by {household.hands} hands. Blind presses every object with "
        "the same force; stiffness uses the estimate from the first contact; a reflex presses "
        "harder on slip (gradual lift, slip detected after 100 ms). Points have 95 % intervals "
        "over objects and hands. The ceiling is the best choice for each single specimen, found "
        "by search.",
        image,
    )


GRASP_PARTS: Mapping[str, Part] = {
    "household": Part("household", "What stiffness saves", tables=household_tables),
}


def grasp_page(state: State) -> Page:
    results = state.findings[0].results
    household = results[HOUSEHOLD]
    size = "running"
    if household is not None:
        size = f"{household.objects} objects, {household.hands} hands, {household.picks} judged "
        size += "pinches"
    return Page(
        title="First contact: grasping (twin results)",
        heading="First contact: what stiffness is worth to a hand",
        intro="Does a hand that knows early how stiff an object is drop and crush less of what "
        "people pick up? The twin's hand closes on household objects, from raspberry to hammer, "
        "with the live detector and the network in the loop. These are results of the twin: they "
        "follow from its assumptions, and do not show what a real hand reaches.",
        badges=[
            "Twin results",
            size,
            state.started,
            state.elapsed,
            f"seed {state.settings['seed']}",
        ],
        warning="Quick study with few pinches: do not quote its numbers",
        outcome=sentences(household) if household else [],
        how=_method_notes(state, household),
    )


def _method_notes(state: State, household: Household | None) -> list[tuple[str, list[str]]]:
    how = {"Seed": str(state.settings["seed"])}
    how["Time"] = f"{state.elapsed} with {state.settings['workers']} workers"
    if household is not None:
        tuned, judged = household.tuned_on, household.judged_on
        families = "; ".join(map(_listed, tuned.families))
        how["Tuned on"] = (
            f"{tuned.picks} pinches by the hands {_listed(tuned.hands)}, specimen "
            f"{_listed(tuned.specimens)} of each object; {tuned.budget} settings of each policy, "
            "or all if there are fewer. Their outcomes come from a table of simulated closings "
            "with each approach speed, force and object. The best setting has the fewest drops at "
            "7, 10 and 13 % damage."
        )
        how["Judged on"] = (
            f"{judged.picks} pinches by the hands {_listed(judged.hands)}, specimens "
            f"{_listed(judged.specimens)}. Families of similar objects are divided into "
            f"{tuned.folds} folds, and each fold is judged with settings tuned without it. "
            f"Families: {families}. Each other object is a family by itself."
        )
    return [(title, [text]) for title, text in how.items()]


def _listed(values: Sequence[object]) -> str:
    return ", ".join(map(str, values))
