"""Sentences and formatted numbers about the results of the grasp study."""

from __future__ import annotations

from firstcontact.core.text import percent as any_percent
from firstcontact.grasp import POLICIES
from firstcontact_lab.grasping.judgement import baseline, candidate
from firstcontact_lab.grasping.results import CEILING, Between, Household

REFERENCES = {
    "label": "exact label",
    "label_rmse_3": "label with noise, RMSE 3",
    "label_rmse_5": "label with noise, RMSE 5",
    "label_rmse_10": "label with noise, RMSE 10",
    CEILING: "ceiling (each specimen known)",
}


def policy_title(name: str) -> str:
    return POLICIES[name].title if name in POLICIES else REFERENCES.get(name, name)


def percent(share: float) -> str:
    return any_percent(share, 0)


def interval_text(number: Between, sign: bool = False) -> str:
    form = "{:+.0f}" if sign else "{:.0f}"
    value, low, high = (form.format(100 * x + 0.0) for x in (number.value, number.low, number.high))
    return f"{value} % ({low} to {high})".replace("-", "−")


def reduction_text(number: Between) -> str:
    """Return a relative reduction as text, such as "40 % (10 to 60) fewer".

    A negative reduction reads "more" instead of "fewer".
    """
    if number.value >= 0:
        return f"{interval_text(number)} fewer"
    return f"{interval_text(Between(value=-number.value, low=-number.high, high=-number.low))} more"


def headline(household: Household) -> str:
    gain = household.fewer_drops_than_blind
    ours, blind = (household.drops_at_10_damage[k.name] for k in (candidate(), baseline()))
    verdict = "met" if household.met else "not met"
    why = ": the interval includes zero" if gain.low <= 0 else ""
    doubt = ": not significant" if gain.low <= 0 <= gain.high else ""
    return (
        f"An estimate of stiffness gives {reduction_text(gain)} drops{doubt}. The hand with it "
        f"drops {percent(ours)} of the objects, the best hand without it {percent(blind)}, "
        f"where both damage {percent(household.damage)}. The target, {percent(household.target)} "
        f"with an interval above zero, is {verdict}{why}. Each of the {household.objects} objects "
        f"is judged on {household.hands} hands, with settings tuned on other hands and on other "
        "kinds of object."
    )


def reflex_sentence(household: Household) -> str:
    parts = [
        f"from {percent(reflex.blind.value)} to {percent(reflex.stiffness.value)} ({name})"
        for name, reflex in household.slip_reflex.items()
    ]
    return (
        "If the hand also presses harder on a slip, stiffness changes the share of drops "
        f"{'; '.join(parts)}. Brackets hold the kind of lift, and the time to detect the slip."
    )


def readme_sentences(household: Household) -> str:
    """Return sentences for the README on how much stiffness reduces drops.

    They state the reduction without and with a slip reflex.
    """
    gain = household.fewer_drops_than_blind
    proof = "" if gain.low > 0 else ", an interval that includes zero"
    by = household.slip_reflex
    none = [name for name, reflex in by.items() if reflex.fewer.value <= 0]
    useful = [reflex.fewer for name, reflex in by.items() if name not in none]
    parts = [
        f"On the twin, a hand with a stiffness estimate before its second contact drops "
        f"{reduction_text(gain)} of {household.objects} household objects than the best hand "
        f"without one, at equal damage{proof}."
    ]
    if none:
        cases = "; ".join(none)
        parts.append(f"With a slip reflex that is quick enough ({cases}) no gain is left.")
    if useful:
        least, most = (round(100 * of(f.value for f in useful)) for of in (min, max))
        late = "Where the reflex comes too late" if none else "With a slip reflex"
        sure = "" if all(f.low > 0 for f in useful) else ", with such intervals"
        parts.append(f"{late}, stiffness saves {least} to {most} % of its drops{sure}.")
    return " ".join(parts)


def sentences(household: Household) -> list[str]:
    return [
        headline(household),
        reflex_sentence(household),
        "The intervals are bootstrap intervals over objects and hands. In each resample, the "
        f"forces of both policies are scaled until {percent(household.damage)} of the objects are "
        "damaged. Without this scaling, and with damage above this share counted as drops, the "
        f"gain is {interval_text(household.fewer_drops_as_bold)}.",
        "Without any scaling of forces, stiffness raises the share of closings without drop or "
        f"damage by {interval_text(household.success_gain, True)}.",
        "As a check, each object gets the weight and the damage limit of another one, so that no "
        "gain is possible. The measured gain is "
        f"{interval_text(household.controls['both_permuted'], True)}.",
    ]
