"""What the report says, made out of the results alone."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from firstcontact.grasp.policies.registry import POLICIES
from firstcontact.grasp.policy import Part
from firstcontact.grasp_study.figures.headline import headline_figure
from firstcontact.grasp_study.figures.latencies import over_latency
from firstcontact.grasp_study.figures.stiffnesses import over_shore
from firstcontact.grasp_study.variants import playing, unmodulated, variants
from firstcontact.twin.plant import LIFT


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


def percent(share: float) -> str:
    """A share as it is read."""
    return f"{100 * share:.0f} %"


def _between(tree: Mapping[str, Any], number: str, form: str, factor: float = 1.0) -> str:
    if number not in tree:
        return "–"
    shown = form.format(factor * tree[number])
    if ends := tree["intervals"].get(number):
        low, high = (form.format(factor * end) for end in ends)
        shown += f" ({low} to {high})"
    return shown


def sentences(results: Mapping[str, Any]) -> list[str]:
    """The headline in words, whether or not the target was met."""
    head = results["headline"]
    said = []
    best = head["best_feedback"]
    for ours in playing(Part.CANDIDATE):
        for other, found in head[ours.key].items():
            soft, lasting = found["soft"], found["lasting"]
            verdict = ""
            if other == best:
                verdict = f"Target {'met' if all(found['met'].values()) else 'not met'}."
            less = {"change": -soft["less_peak"], "intervals": {}}
            if ends := soft["intervals"].get("less_peak"):
                less["intervals"]["change"] = [-end for end in reversed(ends)]
            said.append(
                f"{ours.title.capitalize()} against {variants()[other].title}: "
                f"peak force on objects up to {head['soft_up_to']:g} Shore A "
                f"{_between(less, 'change', '{:+z.0f}', 100)} %, "
                f"time to grasp {_between(lasting, 'longer', '{:+z.0f}', 100)} %, drops "
                f"{found['all']['more_dropped']:+d}, broken {found['all']['more_broken']:+d} of "
                f"{found['all']['n']} closings. {verdict}"
            )
    return said


def tables(results: Mapping[str, Any]) -> list[Table]:
    """Everything at the headline's latency, then what was tuned and what was missed."""
    ms = f"{results['headline']['latency_ms']:g}"
    head = (
        "", "Peak, soft (N)", "Peak, firm (N)", "Time to grasp (ms)", "Steady", "Dropped",
        "Brittle broken (%)",
    )  # fmt: skip
    rows = []
    compared = variants()
    for variant, at in results["policies"].items():
        groups = at[ms]
        rows.append(
            (
                compared[variant].title,
                _between(groups["soft"], "peak_n", "{:.2f}"),
                _between(groups["firm"], "peak_n", "{:.2f}"),
                _between(groups["lasting"], "time_ms", "{:.0f}"),
                percent(groups["lasting"]["steady"]),
                percent(groups["all"]["dropped"]),
                _between(groups["brittle"], "broken", "{:.0f}", 100),
            )
        )
    late = [
        (v.title, *(str(at["all"]["misses"]) for at in results["policies"][v.key].values()))
        for v in playing(Part.CANDIDATE)
    ]
    latencies = [f"{m} ms" for m in next(iter(results["policies"].values()))]
    count = next(iter(results["policies"].values()))[ms]["all"]["n"]
    return [
        Table(f"At {ms} ms brake latency; 95 % intervals draw whole sessions.", head, rows),
        *_tuned(results["feedback"]),
        Table(
            f"Deadlines missed, of {count} closings at each latency: no estimate came that could "
            "be used, and the hand stayed slow and gentle.",
            ("", *latencies),
            late,
        ),
    ]  # fmt: skip


def _tuned(found: Mapping[str, Any]) -> list[Table]:
    """A table for each policy that was tuned."""
    made = []
    for policy in (p for p in POLICIES.values() if p.tunables):
        shown = policy.tunables
        rows = [
            (
                v.title,
                *(f"{t.scale * found[key]['settings'][s]:g} {t.unit}" for s, t in shown.items()),
                str(found[key]["tried"]),
            )
            for key, v in variants().items()
            if v.policy is policy
        ]
        caption = (
            f"What {policy.title} was tuned to: the best of all that was tried, on sessions that "
            "are not in this report."
        )
        made.append(Table(caption, ("", *(t.title for t in shown.values()), "Tried"), rows))
    return made


def _brittle(results: Mapping[str, Any]) -> str:
    """What can break, by name; every object is closed on as often as any other."""
    kinds = [kind.replace("_", " ") for kind, its in results["objects"].items() if its["breaks"]]
    return f"Those that can: {', '.join(kinds)}, each as often"


def pictures(results: Mapping[str, Any]) -> list[Picture]:
    """All figures."""
    policies = results["policies"]
    # Its force is so high that nothing else could be told apart beside it.
    free = unmodulated().key
    others = {variant: at for variant, at in policies.items() if variant != free}
    ms = f"{results['headline']['latency_ms']:g}"
    soft = results["headline"]["soft_up_to"]
    peak = policies[free][ms]["soft"]["peak_n"]
    apart = f"Without modulation it is {peak:.1f} N, which is not drawn."
    bars = "Bars are 95 % bootstrap intervals over sessions."
    return [
        Picture(
            f"At {ms} ms brake latency",
            headline_figure(policies, ms),
            f"Soft objects are those up to {soft:g} Shore A that cannot break. The time is the "
            "mean of the steady grasps of all objects that cannot break. Lines are 95 % bootstrap "
            "intervals over sessions.",
        ),
        Picture(
            "Peak force on soft objects",
            over_latency(others, "soft", "peak_n", "Mean peak force (N)"),
            f"Grip force: the smaller one of both contacts. {apart} {bars}",
        ),
        Picture(
            "Broken objects",
            over_latency(policies, "brittle", "broken", "Brittle objects broken (%)", 100),
            f"{_brittle(results)}. {bars}",
        ),
        Picture(
            "Dropped objects",
            over_latency(policies, "all", "dropped", "Objects dropped (%)", 100, least=5),
            f"All objects, lifted {1e3 * LIFT:g} ms after the first contact. {bars}",
        ),
        Picture(
            "Time to a stable grasp",
            over_latency(policies, "lasting", "time_ms", "Mean time to grasp (ms)"),
            "From the first contact until the force is steady and holds with a quarter to spare; "
            f"grasps that never get there are not in the mean. {bars}",
        ),
        Picture(
            f"Peak force over stiffness, {ms} ms",
            over_shore(results["objects"]),
            f"Blocks and everyday objects that cannot break, the mean of each. {apart}",
        ),
    ]
