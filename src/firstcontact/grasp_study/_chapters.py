"""What the report says, made out of the results alone."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from firstcontact.grasp.policies.registry import POLICIES
from firstcontact.grasp.policy import Part
from firstcontact.grasp_study.figures.headline import headline_figure
from firstcontact.grasp_study.figures.latencies import over_latency
from firstcontact.grasp_study.figures.stiffnesses import over_shore
from firstcontact.grasp_study.results import GraspResults, Tuning
from firstcontact.grasp_study.variants import playing, unmodulated, variants
from firstcontact.learning.scores import Bounded, bounded
from firstcontact.twin.lift import LIFT


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


def _between(found: Bounded | None, form: str, factor: float = 1.0) -> str:
    if found is None:
        return "–"
    shown = form.format(factor * found.value)
    if found.ends:
        low, high = (form.format(factor * end) for end in found.ends)
        shown += f" ({low} to {high})"
    return shown


def sentences(results: GraspResults) -> list[str]:
    """The headline in words, whether or not the target was met."""
    head = results.headline
    said = []
    for ours in playing(Part.CANDIDATE):
        for other, found in head[ours.key].items():
            longer = _between(bounded(found.lasting, "longer"), "{:+z.0f}", 100)
            verdict = ""
            if other == head.about.best_feedback:
                verdict = f"Target {'met' if found.met.all else 'not met'}."
            said.append(
                f"{ours.title.capitalize()} against {variants()[other].title}: "
                f"peak force on objects up to {head.about.soft_up_to:g} Shore A "
                f"{_between(found.soft.peak_change, '{:+z.0f}', 100)} %, "
                f"time to grasp {longer} %, drops "
                f"{found.all.more_dropped:+d}, broken {found.all.more_broken:+d} of "
                f"{found.all.n} closings. {verdict}"
            )
    return said


def tables(results: GraspResults) -> list[Table]:
    """Everything at the headline's latency, then what was tuned and what was missed."""
    ms = results.latency
    head = (
        "", "Peak, soft (N)", "Peak, firm (N)", "Time to grasp (ms)", "Steady", "Dropped",
        "Brittle broken (%)",
    )  # fmt: skip
    rows = []
    compared = variants()
    for variant, at in results.policies.items():
        groups = at[ms]
        rows.append(
            (
                compared[variant].title,
                _between(bounded(groups["soft"], "peak_n"), "{:.2f}"),
                _between(bounded(groups["firm"], "peak_n"), "{:.2f}"),
                _between(bounded(groups["lasting"], "time_ms"), "{:.0f}"),
                percent(groups["lasting"].steady),
                percent(groups["all"].dropped),
                _between(bounded(groups["brittle"], "broken"), "{:.0f}", 100),
            )
        )
    late = [
        (v.title, *(str(at["all"].misses) for at in results.policies[v.key].values()))
        for v in playing(Part.CANDIDATE)
    ]
    latencies = [f"{m} ms" for m in next(iter(results.policies.values()))]
    count = next(iter(results.policies.values()))[ms]["all"].n
    return [
        Table(f"At {ms} ms brake latency; 95 % intervals draw whole sessions.", head, rows),
        *_tuned(results.feedback),
        Table(
            f"Deadlines missed, of {count} closings at each latency: no estimate came that could "
            "be used, and the hand stayed slow and gentle.",
            ("", *latencies),
            late,
        ),
    ]  # fmt: skip


def _tuned(found: Mapping[str, Tuning]) -> list[Table]:
    """A table for each policy that was tuned."""
    made = []
    for policy in (p for p in POLICIES.values() if p.tunables):
        shown = policy.tunables
        rows = [
            (
                v.title,
                *(f"{t.scale * found[key].settings[s]:g} {t.unit}" for s, t in shown.items()),
                str(found[key].tried),
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


def _brittle(results: GraspResults) -> str:
    """What can break, by name; every object is closed on as often as any other."""
    kinds = [kind.replace("_", " ") for kind, its in results.objects.items() if its.breaks]
    return f"Those that can: {', '.join(kinds)}, each as often"


def pictures(results: GraspResults) -> list[Picture]:
    """All figures."""
    policies = results.policies
    # Its force is so high that nothing else could be told apart beside it.
    free = unmodulated().key
    others = {variant: at for variant, at in policies.items() if variant != free}
    ms = results.latency
    soft = results.headline.about.soft_up_to
    peak = policies[free][ms]["soft"].peak_n
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
            over_shore(results.objects),
            f"Blocks and everyday objects that cannot break, the mean of each. {apart}",
        ),
    ]
