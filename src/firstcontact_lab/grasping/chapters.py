"""Report of the grasp study, made from its ``results.json`` and film."""

from __future__ import annotations

import base64
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from statistics import median

from firstcontact.grasp import POLICIES, Policy
from firstcontact.models import bounded
from firstcontact_lab.grasping._estimates import FIRMEST, USED
from firstcontact_lab.grasping._household_numbers import baseline, candidate
from firstcontact_lab.grasping._variants import variants
from firstcontact_lab.grasping.figures import fronts_figure
from firstcontact_lab.grasping.results import (
    Between,
    GraspResults,
    Household,
    ObjectErrors,
    RealClosings,
    Reflexes,
    Summary,
)
from firstcontact_lab.grasping.sentences import percent, policy_title, sentences
from firstcontact_lab.report.findings import Figure
from firstcontact_lab.report.page import Column, Page, Section
from firstcontact_lab.report.state import duration
from firstcontact_lab.report.tables import Cell, Line, Row, Table, Value, format_cell, matrix

#: Approximate Shore A of the firmest object in the training of the network.
MET = 80.0
CONTROLS = {
    "mass_permuted": "Weights of other objects",
    "damage_permuted": "Damage limits of other objects",
    "both_permuted": "Both (must be 0 within its interval)",
}


def tables(results: GraspResults) -> list[Table]:
    """Return all tables of the report."""
    household = results.household
    return [
        policies_table(household),
        reflex_table(household),
        controls_table(household),
        closings_table(household),
        estimates_table(household),
        sensitivity_table(household),
        objects_table(household),
        *_tuned(household),
        payload_table(results),
    ]


def _table(caption: str, rows: Sequence[Row[str]], entries: Mapping[str, str]) -> Table:
    """Return a table with one line per entry."""
    lines = [(Cell(title), key, False) for key, title in entries.items()]
    return matrix(caption, rows, lines) or Table(caption, ["", *(row.label for row in rows)], [])


def policies_table(household: Household) -> Table:
    """Return the table of drops and successes of each policy."""

    def drops(name: str) -> Value:
        between = household.drops_between.get(name)
        return household.drops_at_10_damage[name] if between is None else between.bounded

    def fewer(name: str) -> Value:
        between = household.fewer.get(name)
        return None if between is None else between.bounded

    return _table(
        "Share of objects that each policy drops if its forces are scaled until "
        f"{percent(household.damage)} are damaged. In the last column the forces are not scaled. "
        "The intervals come from drawing hands, and kinds of object within each group (soft or "
        "firm, fragile or robust), with replacement. In rows with a reflex the hand lifts "
        "gradually, and a slip is detected after 100 ms. A label with noise is the true Shore A "
        "plus a normal error of the stated RMSE.",
        [
            Row("Dropped", drops, "whole"),
            Row("Fewer than blind", fewer, "whole"),
            Row("Neither dropped nor damaged", household.success.__getitem__, "whole"),
        ],
        {name: policy_title(name) for name in household.drops_at_10_damage},
    )


def reflex_table(household: Household) -> Table:
    """Return the table of drops with a slip reflex, with and without stiffness."""

    def lookup(value: Callable[[Reflexes], Value]) -> Callable[[str], Value]:
        return lambda name: value(household.slip_reflex[name])

    return _table(
        "Drops and success of policies with a slip reflex: alone, and with the stiffness "
        "estimate. Drops are at equal damage. The support disappears immediately (abrupt) or "
        "within a second (gradual). After the stated latency of the detection, the brake needs "
        "20 ms and the force must build up.",
        [
            Row("Reflex alone", lookup(lambda r: r.blind.bounded), "whole"),
            Row("Stiffness, too", lookup(lambda r: r.stiffness.bounded), "whole"),
            Row("Fewer", lookup(lambda r: r.fewer.bounded), "whole"),
            Row("Success, alone", lookup(lambda r: r.success.blind), "whole"),
            Row("Success, both", lookup(lambda r: r.success.stiffness), "whole"),
        ],
        {name: name for name in household.slip_reflex},
    )


def _gains(
    caption: str, household: Mapping[str, Between], unit: str, titles: Mapping[str, str]
) -> Table:
    row = Row[str]("Fewer drops than blind", lambda name: household[name].bounded, unit)
    return _table(caption, [row], titles)


def controls_table(household: Household) -> Table:
    """Return the table of the gain from stiffness that remains in each control."""
    return _gains(
        "Controls: reduction of drops if each object gets the weight or the damage limit of "
        "another object, drawn at random. Both policies are tuned again. Mean and middle 95 % of "
        "the permutations.",
        household.controls,
        "gain",
        {name: CONTROLS.get(name, name) for name in household.controls},
    )


def sensitivity_table(household: Household) -> Table:
    """Return the table of the gain from stiffness if objects' estimated properties change."""
    return _gains(
        "Reduction of drops if the estimated numbers of the household have other values. Both "
        "policies are tuned again. The last row has the smallest and the largest value of its "
        "draws instead of an interval.",
        household.sensitivity,
        "whole",
        {name: name[0].upper() + name[1:] for name in household.sensitivity},
    )


def closings_table(household: Household) -> Table:
    """Return the table of the outcomes of full closings."""

    def lookup(value: Callable[[RealClosings], Value]) -> Callable[[str], Value]:
        return lambda name: value(household.closings[name])

    return _table(
        "Closings that are simulated in full at the tuned settings, with the live estimates and "
        "their deadline. Steady: share with a constant force, a quarter above the holding force. "
        "As tabulated: share with the outcome that the table of closings, used for tuning, "
        "predicts.",
        [
            Row("Success", lookup(lambda c: bounded(c, "success")), "whole"),
            Row("Dropped", lookup(lambda c: bounded(c, "dropped")), "whole"),
            Row("Damaged", lookup(lambda c: bounded(c, "damaged")), "whole"),
            Row("Steady", lookup(lambda c: c.steady), "whole"),
            Row("Time to a steady grasp", lookup(lambda c: c.steady_ms), "whole ms"),
            Row("Estimate by the deadline", lookup(lambda c: c.in_time), "whole"),
            Row("As tabulated", lookup(lambda c: c.as_table), "whole"),
        ],
        {name: policy_title(name) for name in household.closings},
    )


def estimates_table(household: Household) -> Table:
    """Return the table of errors and times of the live estimates."""
    entry = household.estimates
    windows = list(entry.rmse)

    def line(title: str, values: Mapping[str, float], unit: str) -> Line:
        return Line([Cell(title), *(format_cell(values.get(window), unit) for window in windows)])

    return Table(
        f"Live estimates of the judged pinches. {_firm(household)}On held-out pinches of the "
        f"hands' own blocks the RMSE is {entry.block_rmse:.1f}. {percent(entry.unanswered)} of "
        "pinches had "
        f"no estimate before the second contact, and {percent(entry.heard)} of second contacts "
        "were detected.",
        ("", *(w if w == USED else f"{w} ms" for w in windows)),
        [
            line("RMSE, all objects (Shore A)", entry.rmse, "one"),
            line(f"RMSE, objects up to {FIRMEST:g} Shore A", entry.bearing, "one"),
            line("Window complete before the second contact", entry.decided, "whole"),
        ],
    )


def _firm(household: Household) -> str:
    """Return a sentence about objects firmer than the training data; "" if there are none."""
    answered = {n: entry for n, entry in household.by_object.items() if entry.bias is not None}
    firm = [entry for entry in answered.values() if entry.shore_a > MET]
    if not firm:
        return ""
    labels = [entry.shore_a for entry in firm]
    read = median(entry.shore_a + (entry.bias or 0.0) for entry in firm)
    squares = {n: entry.answered * entry.rmse[USED] ** 2 for n, entry in answered.items()}
    part = sum(squares[n] for n, entry in answered.items() if entry.shore_a > MET)
    return (
        f"The network was not trained on objects much firmer than {MET:g} Shore A. For {len(firm)} "
        f"objects of {min(labels):g} to {max(labels):g} the median prediction is {read:.0f}. They "
        f"contribute {percent(part / sum(squares.values()))} of the squared error. "
    )


def objects_table(household: Household) -> Table:
    """Return the table of errors, drops and damage of each object."""

    def lookup(value: Callable[[ObjectErrors], Value]) -> Callable[[str], Value]:
        return lambda name: value(household.by_object[name])

    def outcome(policy: str) -> Callable[[ObjectErrors], str]:
        return lambda o: f"{percent(o.drops[policy])} / {percent(o.damage[policy])}"

    def error(window: str) -> Callable[[ObjectErrors], Value]:
        return lambda o: o.rmse.get(window)

    return _table(
        "By object: RMSE for each window, mean error of the estimates that were used, and the "
        "shares dropped / damaged with settings tuned without the object's family.",
        [
            Row("Shore A", lookup(lambda o: f"{o.shore_a:g}")),
            *(
                Row(window if window == USED else f"{window} ms", lookup(error(window)))
                for window in household.estimates.rmse
            ),
            Row("Mean error", lookup(lambda o: o.bias), "bias"),
            *(Row(p.title, lookup(outcome(p.name))) for p in (baseline(), candidate())),
        ],
        {name: name for name in household.by_object},
    )


def _tuned(household: Household) -> list[Table]:
    made = []
    on = household.tuned_on
    for name, chosen in household.tuned.items():
        policy = POLICIES.get(name)
        if policy is None:
            continue
        lines = [
            Line(
                [
                    Cell(str(fold + 1)),
                    *(Cell(_setting(policy, key, one.settings[key])) for key in policy.tunables),
                    Cell(f"{one.settings['scale']:.2f}"),
                    Cell(str(one.tried)),
                    Cell(f"{percent(one.drops)} / {percent(one.damage)}"),
                ]
            )
            for fold, one in enumerate(chosen)
        ]
        titles = [tunable.title for tunable in policy.tunables.values()]
        made.append(
            Table(
                f"Settings of {policy.title}, one row for each fold. The families of the fold were "
                f"left out of the choice. It used {on.picks} pinches by the hands {on.hands[0]} to "
                f"{on.hands[-1]}; none of these pinches is judged. Last column: shares dropped / "
                "damaged in these pinches.",
                ("Fold", *titles, "Scale", "Tried", "There"),
                lines,
            )
        )
    return made


def _setting(policy: type[Policy], key: str, value: float) -> str:
    tunable = policy.tunables[key]
    return f"{tunable.scale * value:g} {tunable.unit}"


def payload_table(results: GraspResults) -> Table:
    """Return the table of the payload task."""
    payload, ms = results.payload, results.latency

    def group(key: str, name: str) -> Callable[[str], Value]:
        def value(policy: str) -> Value:
            summary: Summary | None = payload.policies[policy][ms].get(name)
            return bounded(summary, key)

        return value

    return _table(
        "Earlier task: hold a known payload of 0.2 kg with little peak force on soft blocks, "
        f"{payload.data.closings} closings at {ms} ms brake latency. Stiffness helps little here, "
        "because the same force holds the payload for every object.",
        [
            Row("Peak, soft", group("peak_n", "soft"), "newton"),
            Row("Time to grasp", group("time_ms", "lasting"), "whole ms"),
            Row("Dropped", lambda name: payload.policies[name][ms]["all"].dropped, "whole"),
            Row("Brittle broken", group("broken", "brittle"), "whole"),
        ],
        {key: variant.title for key, variant in variants().items()},
    )


def fronts(results: GraspResults) -> Figure:
    """Return the figure of the trade-off between drops and damage, by policy."""
    household = results.household
    return Figure(
        "fronts",
        "Dropped and damaged objects, from cautious to bold",
        f"Each line is one policy from cautious (left) to bold, on {household.picks} pinches of "
        f"{household.objects} objects by {household.hands} hands. Blind presses every object with "
        "the same force; stiffness uses the estimate from the first contact; a reflex presses "
        "harder on slip (gradual lift, slip detected after 100 ms). Points have 95 % intervals "
        "over objects and hands. The ceiling is the best choice for each single specimen, found "
        "by search.",
        fronts_figure(household),
    )


def _film(results: GraspResults, film: Path) -> Figure:
    shown_objects, hand, specimen = results.film.objects, results.film.hand, results.film.specimen
    return Figure(
        "film",
        f"{' and '.join(shown_objects).capitalize()}, picked up by the same hand",
        "Left: without stiffness; right: with it. Both policies were tuned without the families of "
        f"these objects. Hand {hand}, specimen {specimen}. Dotted line: second contact; dashed "
        "line: the object is lifted, 450 ms after the first contact.",
        f"data:image/gif;base64,{base64.b64encode(film.read_bytes()).decode()}",
    )


def render(results: GraspResults, film: Path) -> str:
    """Return the report, HTML."""
    run, household = results.study, results.household
    first, *further = tables(results)
    details = [Column("", further, [])]
    figures = [fronts(results), _film(results, film)]
    return Page(
        title="First contact: grasping (twin results)",
        heading="First contact: what stiffness is worth to a hand",
        intro="Does a hand that knows early how stiff an object is drop and crush less of what "
        "people pick up? The twin's hand closes on household objects, from raspberry to hammer, "
        "with the live detector and the network in the loop. These are results of the twin: they "
        "follow from its assumptions, and do not show what a real hand reaches.",
        badges=[
            "Twin results",
            f"{household.objects} objects, {household.hands} hands, {household.picks} judged "
            "pinches",
            run.started,
            duration(run.seconds),
            f"seed {run.seed}",
        ],
        warning="Quick study with few pinches: do not quote its numbers" if run.quick else "",
        sections=[
            Section(
                "results",
                "What stiffness saves",
                "",
                sentences=sentences(results),
                figures=figures,
                table=first,
                details=details,
            ),
        ],
        command=run.command,
        how=[(title, [text]) for title, text in _how(results).items()],
        versions=run.versions,
    ).html()


def _how(results: GraspResults) -> dict[str, str]:
    run, household, payload = results.study, results.household, results.payload
    tuned, judged = household.tuned_on, household.judged_on

    def listed(values: Sequence[object]) -> str:
        return ", ".join(map(str, values))

    errors = [f"{ms} ms window {rmse:.1f}" for ms, rmse in payload.models.rmse.items()]
    families = "; ".join(map(listed, tuned.families))
    return {
        "Every policy": "slows down at the first contact, and presses with one force after the "
        "second. Only this force depends on what the policy knows. The estimate is the live "
        "pipeline's last one before the second contact. A command acts 20 ms after the block of "
        "samples that caused it.",
        "Tuned on": f"{tuned.picks} pinches by the hands {listed(tuned.hands)}, specimen "
        f"{listed(tuned.specimens)} of each object; {tuned.budget} settings of each policy, or all "
        "if there are fewer. Their outcomes come from a table of simulated closings with each "
        "approach speed, force and object. The best setting has the fewest drops at 7, 10 and 13 % "
        "damage. Each pinch represents specimens whose needed and tolerated forces scatter by a "
        "fifth. Nothing else was tuned.",
        "Judged on": f"{judged.picks} pinches by the hands {listed(judged.hands)}, specimens "
        f"{listed(judged.specimens)}. Families of similar objects are divided into {tuned.folds} "
        "folds, and each fold is judged with settings tuned without it. "
        f"Families: {families}. Each other object is a family by itself.",
        "Models of a hand": "come from its own pinches of five blocks, at the judged approach "
        "speed, with contacts from its detector.",
        "Fronts": "come from a table of simulated closings of the judged pinches. The table of "
        "full closings states how often a policy in the loop has the same outcome.",
        "Earlier task": f"{listed(payload.data.objects)}; each in {payload.data.sessions} "
        f"sessions. Its models were trained on {payload.data.training} pinches. RMSE on held-out "
        f"sessions: {', '.join(errors)} Shore A.",
        "Seed": str(run.seed),
        "Time": f"{duration(run.seconds)} with {run.workers} workers",
    }
