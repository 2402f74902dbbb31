"""Tables and pictures of the report, made out of the results alone."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from statistics import median

from firstcontact.grasp import POLICIES, Policy
from firstcontact.models import Bounded, bounded
from firstcontact_lab.grasping._estimates import FIRMEST, USED
from firstcontact_lab.grasping._household_numbers import baseline, candidate
from firstcontact_lab.grasping._variants import variants
from firstcontact_lab.grasping._words import ends, percent, title_of
from firstcontact_lab.grasping.figures.fronts import fronts_figure
from firstcontact_lab.grasping.figures.objects import objects_figure
from firstcontact_lab.grasping.results import GraspResults, Household

#: The firmest that the network learned from, about, Shore A.
MET = 80.0
CONTROLS = {
    "mass_permuted": "Weights of other things",
    "damage_permuted": "Damage limits of other things",
    "both_permuted": "Both (must be 0 within its interval)",
}


@dataclass(frozen=True, slots=True)
class Picture:
    """A figure: title, image (data URI), caption."""

    title: str
    image: str
    caption: str


@dataclass(frozen=True, slots=True)
class Table:
    """Caption, head and rows."""

    caption: str
    head: Sequence[str]
    rows: Sequence[Sequence[str]]


def tables(results: GraspResults) -> list[Table]:
    """Everything in numbers, what was tuned last."""
    found = results.household
    return [
        policies_table(found),
        reflex_table(found),
        controls_table(found),
        closings_table(found),
        estimates_table(found),
        sensitivity_table(found),
        objects_table(found),
        *_tuned(found),
        payload_table(results),
    ]


def policies_table(found: Household) -> Table:
    """Who knows what, and what it is worth."""
    rows = []
    for name, dropped in found.drops_at_10_damage.items():
        between = found.drops_between.get(name)
        fewer = found.fewer.get(name)
        rows.append(
            (
                title_of(name),
                percent(dropped) if between is None else ends(between),
                "–" if fewer is None else ends(fewer),
                percent(found.success[name]),
            )
        )
    return Table(
        f"Drops where {percent(found.damage)} are damaged, by what is known; success as tuned. "
        "Intervals draw kinds (within their groups) and hands. Reflex rows: lifted gradually, the "
        "slip known after 100 ms. Labels with noise have a normal error of that RMSE.",
        ("", "Dropped", "Fewer than blind", "Neither dropped nor damaged"),
        rows,
    )


def reflex_table(found: Household) -> Table:
    """What is left of stiffness with a reflex."""
    rows = [
        (name, ends(its.blind), ends(its.stiffness), ends(its.fewer),
         percent(its.success.blind), percent(its.success.stiffness))
        for name, its in found.slip_reflex.items()
    ]  # fmt: skip
    return Table(
        "With a slip reflex: drops at the same damage without and with stiffness, and success. The "
        "support goes at once (abrupt) or within a second (gradual); to the latency of the "
        "detection "
        "20 ms of brake and the time to build the force up are added.",
        ("Lift, detection", "Reflex alone", "Stiffness, too", "Fewer", "Success, alone",
         "Success, both"),
        rows,
    )  # fmt: skip


def controls_table(found: Household) -> Table:
    """What must be left, and what must not."""
    rows = [(CONTROLS.get(n, n), ends(b, True)) for n, b in found.controls.items()]
    return Table(
        "Controls: fewer drops than blind where the same things were given others' weights or "
        "limits by chance, everybody tuned anew; mean and middle 95 % of permutations.",
        ("", "Fewer drops than blind"),
        rows,
    )


def closings_table(found: Household) -> Table:
    """What was closed in full."""
    rows = []
    for name, its in found.closings.items():
        shares = [
            f"{percent(getattr(its, what))} ({100 * its.intervals[what][0]:.0f} to "
            f"{100 * its.intervals[what][1]:.0f})"
            for what in ("success", "dropped", "damaged")
        ]
        time = "–" if its.steady_ms is None else f"{its.steady_ms:.0f} ms"
        alike = "–" if its.as_table is None else percent(its.as_table)
        timely = "–" if its.in_time is None else percent(its.in_time)
        rows.append((title_of(name), *shares, percent(its.steady), time, timely, alike))
    return Table(
        "Closings in full, as tuned: plant, filter, detector, any-time estimator, loop with its "
        "deadline. Steady: the force is steady and a quarter more than just holds. As the table: "
        "how often the table of closings that fronts are read off has the same end.",
        (
            "",
            "Success",
            "Dropped",
            "Damaged",
            "Steady",
            "Time to a steady grasp",
            "Estimate by the deadline",
            "As the table",
        ),
        rows,
    )


def estimates_table(found: Household) -> Table:
    """How good estimates were, and when."""
    its = found.estimates
    windows = list(its.rmse)

    def row(title: str, values: dict[str, float], form: str, factor: float = 1.0) -> list[str]:
        return [
            title,
            *(form.format(factor * values[w]) if w in values else "–" for w in windows),
        ]

    return Table(
        f"The live estimates of judged pinches. {_firm(found)}On pinches of the hands' own blocks "
        f"that were held out the RMSE is {its.block_rmse:.1f}; {percent(its.unanswered)} of "
        f"pinches had no estimate before the second contact, and {percent(its.heard)} of second "
        "contacts were heard.",
        ("", *(w if w == USED else f"{w} ms" for w in windows)),
        [
            row("RMSE, all things (Shore A)", its.rmse, "{:.1f}"),
            row(f"RMSE, things up to {FIRMEST:g} Shore A", its.bearing, "{:.1f}"),
            row("Whole before the second contact", its.decided, "{:.0f} %", 100),
        ],
    )


def _firm(found: Household) -> str:
    """How things beyond what the network has met are read; nothing where there are none."""
    answered = {n: its for n, its in found.by_object.items() if its.bias is not None}
    firm = [its for its in answered.values() if its.shore_a > MET]
    if not firm:
        return ""
    labels = [its.shore_a for its in firm]
    read = median(its.shore_a + (its.bias or 0.0) for its in firm)
    squares = {n: its.answered * its.rmse[USED] ** 2 for n, its in answered.items()}
    part = sum(squares[n] for n, its in answered.items() if its.shore_a > MET)
    return (
        f"The network has never met anything much firmer than {MET:g} Shore A: {len(firm)} things "
        f"of {min(labels):g} to {max(labels):g} read as {read:.0f} at the median, and make "
        f"{percent(part / sum(squares.values()))} of the squared error over all. "
    )


def sensitivity_table(found: Household) -> Table:
    """What if the estimated numbers are wrong."""
    return Table(
        "Numbers of the objects that are estimates, changed: what is gained then, everybody tuned "
        "anew. The last row has the least and the most of its draws instead of an interval.",
        ("", "Fewer drops than blind"),
        [(title[0].upper() + title[1:], ends(b)) for title, b in found.sensitivity.items()],
    )


def objects_table(found: Household) -> Table:
    """Object by object."""
    rows = []
    for name, its in found.by_object.items():
        rmse = [f"{its.rmse[w]:.0f}" if w in its.rmse else "–" for w in found.estimates.rmse]
        bias = "–" if its.bias is None else f"{its.bias:+.0f}"
        ours = [
            f"{percent(its.drops[p])} / {percent(its.damage[p])}"
            for p in (baseline().name, candidate().name)
        ]
        rows.append((name, f"{its.shore_a:g}", *rmse, bias, *ours))
    heads = [w if w == USED else f"{w} ms" for w in found.estimates.rmse]
    return Table(
        "By object: RMSE by window, mean error of what was used, and what was dropped / damaged as "
        "tuned without its family.",
        ("", "Shore A", *heads, "Mean error", baseline().title, candidate().title),
        rows,
    )


def _tuned(found: Household) -> list[Table]:
    made = []
    for name, chosen in found.tuned.items():
        policy = POLICIES.get(name)
        if policy is None:
            continue
        rows = [
            (
                str(fold + 1),
                *(_setting(policy, key, one.settings[key]) for key in policy.tunables),
                f"{one.settings['scale']:.2f}",
                str(one.tried),
                f"{percent(one.drops)} / {percent(one.damage)}",
            )
            for fold, one in enumerate(chosen)
        ]
        on = found.tuned_on
        titles = [t.title for t in policy.tunables.values()]
        made.append(
            Table(
                f"What {policy.title} was tuned to, by the fold whose families were left out; on "
                f"{on.picks} pinches of hands {on.hands[0]} to {on.hands[-1]}, of which none is "
                f"judged. "
                "Last: dropped / damaged there.",
                ("Fold", *titles, "Scale", "Tried", "There"),
                rows,
            )
        )
    return made


def _setting(policy: type[Policy], key: str, value: float) -> str:
    shown = policy.tunables[key]
    return f"{shown.scale * value:g} {shown.unit}"


def payload_table(results: GraspResults) -> Table:
    """The older task."""
    payload, ms = results.payload, results.latency
    rows = []
    for key, variant in variants().items():
        groups = payload.policies[key][ms]
        rows.append(
            (
                variant.title,
                _between(bounded(groups.get("soft"), "peak_n"), "{:.2f}"),
                _between(bounded(groups.get("lasting"), "time_ms"), "{:.0f}"),
                percent(groups["all"].dropped),
                _between(bounded(groups.get("brittle"), "broken"), "{:.0f}", 100),
            )
        )
    return Table(
        "The older task: a declared payload of 0.2 kg, peak force on soft blocks, "
        f"{payload.data.closings} closings at {ms} ms brake latency. There is little to gain: the "
        "force that holds the payload is the same for everything.",
        ("", "Peak, soft (N)", "Time to grasp (ms)", "Dropped", "Brittle broken (%)"),
        rows,
    )


def _between(found: Bounded | None, form: str, factor: float = 1.0) -> str:
    if found is None:
        return "–"
    shown = form.format(factor * found.value)
    if found.ends:
        low, high = (form.format(factor * end) for end in found.ends)
        shown += f" ({low} to {high})"
    return shown


def fronts(results: GraspResults) -> Picture:
    """The figure that the report opens with."""
    found = results.household
    return Picture(
        "What a hand drops, and what it damages",
        fronts_figure(found),
        f"Each line is one policy from cautious (left) to bold, on {found.picks} pinches of "
        f"{found.objects} things by {found.hands} hands. Blind presses everything with the same "
        "force; stiffness is heard at the first contact; a reflex presses harder when it slips "
        "(lifted gradually, the slip known after 100 ms). Points have 95 % intervals over things "
        "and hands. The ceiling is the best that can be done to each single specimen, found by "
        "search.",
    )


def pictures(results: GraspResults) -> list[Picture]:
    """The others."""
    return [
        Picture(
            "The estimate, thing by thing",
            objects_figure(results.household),
            "In brackets the label. A white line is the part of the error that is the same in all "
            "pinches of a thing.",
        )
    ]
