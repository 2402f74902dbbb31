"""What the results come to, in sentences."""

from __future__ import annotations

from firstcontact_lab.grasping._household_numbers import baseline, candidate
from firstcontact_lab.grasping._words import ends, percent
from firstcontact_lab.grasping.results import GraspResults, Household


def headline(found: Household) -> str:
    """The gain in a sentence, whether or not the target was met."""
    gain = found.fewer_drops_than_blind
    ours, blind = (found.drops_at_10_damage[k.name] for k in (candidate(), baseline()))
    verdict = "met" if found.met else "not met"
    why = ": the interval includes zero" if gain.low <= 0 else ""
    return (
        "A hand that knows stiffness before its second finger touches drops "
        f"{ends(gain)} fewer of {found.objects} household things than the best blind rule where "
        f"both damage {percent(found.damage)}: {percent(ours)} instead of {percent(blind)} of "
        f"closings, on kinds of things and {found.hands} hands that nothing was tuned on. The "
        f"target of {percent(found.target)} with an interval without zero is {verdict}{why}."
    )


def reflex_sentence(found: Household) -> str:
    """What is left of it with a slip reflex."""
    said = [
        f"{percent(its.blind.value)} to {percent(its.stiffness.value)} ({name})"
        for name, its in found.slip_reflex.items()
    ]
    return (
        "Where the hand has a slip reflex anyway, knowing stiffness takes its drops from "
        f"{', '.join(said)}; in brackets how it is lifted, and how long after it began a slip is "
        "known."
    )


def shortly(found: Household) -> str:
    """What it is worth, and what a slip reflex leaves of it, in few numbers."""
    gain = found.fewer_drops_than_blind
    proof = "" if gain.low > 0 else ", an interval that includes zero"
    by = found.slip_reflex
    none = [name for name, its in by.items() if its.fewer.value <= 0]
    some = [its.fewer for name, its in by.items() if name not in none]
    said = [
        f"On the twin, a hand that knows stiffness before its second finger touches drops "
        f"{ends(gain)} fewer of {found.objects} household things than the best blind rule at equal "
        f"damage{proof}."
    ]
    if none:
        where = "; ".join(none)
        said.append(f"With a slip reflex that is quick enough ({where}) nothing is left of it.")
    if some:
        least, most = (round(100 * of(f.value for f in some)) for of in (min, max))
        late = "Where the reflex comes too late" if none else "With a slip reflex"
        sure = "" if all(f.low > 0 for f in some) else ", with such intervals"
        said.append(f"{late}, stiffness saves {least} to {most} % of its drops{sure}.")
    return " ".join(said)


def sentences(results: GraspResults) -> list[str]:
    """The headline, what a reflex leaves of it, and how far it can be trusted."""
    found = results.household
    return [
        headline(found),
        reflex_sentence(found),
        f"In brackets, 95 % intervals over things and hands: where others are drawn, both rules "
        f"are again as bold as damages {percent(found.damage)} there. Kept as bold as before, with "
        "what stiffness then damages more counted as dropped, it is "
        f"{ends(found.fewer_drops_as_bold)}.",
        f"In closings in full, as tuned, {ends(found.success_gain, True)} more end well with "
        "stiffness, neither dropped nor damaged.",
        "A control: where every thing has the weight and the limit of another there is nothing to "
        f"gain, and {ends(found.controls['both_permuted'], True)} is gained.",
    ]
