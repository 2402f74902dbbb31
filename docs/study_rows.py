"""Rows of the study's tables: what each is called, where its number is, what was published."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from table_rows import Number, Row, Rows, of

from firstcontact.contact import DETECTORS
from firstcontact.models import Bounded, DetectionScores, InferenceTime, bounded, window_estimators
from firstcontact_lab.report.accepted import Accepted
from firstcontact_lab.report.results.anytime import AnytimeResults
from firstcontact_lab.report.results.contact import AnswerTimes
from firstcontact_lab.report.results.data import Offsets
from firstcontact_lab.report.results.hardness import HardnessOrder
from firstcontact_lab.report.results.stiffness import InferenceTimes
from firstcontact_lab.report.results.study import FirstSubject, SubjectResults

#: What the paper states, by the name of the detector, or of the estimator.
WINDOWS_RIGHT = {"three_sigma": "90.6 %", "svm": "100 %"}
ACCURACY = {"svm": "97.2 %", "cnn": "98.6 %"}
ERROR = {"svm": "4.17 (as “MSE”)", "cnn": "2.39 (as “MSE”)"}
TIME = {"svm": "< 1 ms", "cnn": "1.4 ms"}
#: Estimators that are scored in tables; baselines stand in the report alone.
SCORED = {name: kind for name, kind in window_estimators().items() if not kind.baseline}


def contact(key: str, name: str, published: str, accepted: Accepted) -> Rows:
    """Rows of a detector, which say what was accepted."""
    after = " after its label" if accepted.early else ""

    def its(number: Callable[[DetectionScores], Number]) -> Callable[[SubjectResults], Number]:
        return of(lambda r: r.contact.get(key), number)

    return [
        Row(
            f"contact, {name}: windows right", its(lambda s: s.window_accuracy), "share", published
        ),
        Row(
            f"contact, {name}: contact windows found",
            its(lambda s: s.contact_windows_found),
            "share",
        ),
        Row(
            f"contact, {name}: placed {accepted.placed}, pinches",
            its(lambda s: s.pinch_success),
            "share",
        ),
        Row(
            f"contact, {name}: and decided {accepted.decided}",
            its(lambda s: s.decided_within_3_ms),
            "share",
        ),
        Row(
            f"contact, {name}: false alarms a minute",
            its(lambda s: s.false_alarms_per_minute),
            "rate",
        ),
        Row(
            f"contact, {name}: median delay of the decision{after}",
            its(lambda s: s.median_delay),
            "ms",
        ),
    ]


def stiffness(key: str, name: str, accuracy: str, error: str) -> Rows:
    """Rows of a model."""

    def blocks(split: str, score: str) -> Callable[[SubjectResults], Number]:
        return of(lambda r: r.blocks.get(key), lambda s: bounded(s.split(split), score))

    def objects(score: str) -> Callable[[SubjectResults], Number]:
        return lambda r: bounded(r.objects.get(key), score)

    random = blocks("random_90_10", "accuracy")
    return [
        Row(f"5 blocks, {name}: accuracy, random 90/10", random, "share", accuracy),
        Row(f"5 blocks, {name}: accuracy, by session", blocks("by_session", "accuracy"), "share"),
        Row(f"5 blocks, {name}: RMSE, by session", blocks("by_session", "rmse"), "shore"),
        Row(f"8 unseen objects, {name}: RMSE", objects("rmse"), "shore"),
        Row(f"8 unseen objects, {name}: MAE", objects("mae"), "shore"),
        Row(f"8 unseen objects, {name}: MSE", objects("mse"), "shore", error),
    ]


def at_any_time(ms: str) -> Callable[[SubjectResults], Number]:
    """Error so long after the contact."""

    def found(a: AnytimeResults) -> Number:
        ends = a.intervals.get("rmse", {}).get(ms)
        return Bounded(a.rmse[ms], ends) if ms in a.rmse else None

    return of(lambda r: r.anytime, found)


def times(key: str) -> Callable[[SubjectResults], InferenceTimes | None]:
    """How long a model takes."""
    return lambda r: (r.inference_us or {}).get(key)


def speed(key: str, name: str, published: str) -> Rows:
    """Rows of a model's inference."""

    def classifier(r: SubjectResults) -> InferenceTime | None:
        found = times(key)(r)
        return found.classification if found else None

    return [
        Row(f"{name}: one window, median", of(times(key), lambda t: t.p50), "us", published),
        Row(f"{name}: one window, p99", of(times(key), lambda t: t.p99), "us"),
        Row(
            f"{name}: p99 with preempted calls",
            of(times(key), lambda t: t.p99_with_preempted),
            "us",
        ),
        Row(
            f"{name}: faster than its training library",
            of(times(key), lambda t: t.speedup),
            "ratio",
        ),
        Row(f"{name} classifier: one window, p99", of(classifier, lambda t: t.p99), "us"),
        Row(
            f"{name} classifier: faster than its training library",
            of(classifier, lambda t: t.speedup),
            "ratio",
        ),
    ]


def answer(number: Callable[[AnswerTimes], Number]) -> Callable[[SubjectResults], Number]:
    """Of the time to an answer."""
    return of(lambda r: r.answer_ms, number)


def detection(found: Sequence[SubjectResults]) -> Rows:
    """Rows of all detectors and of the time to an answer."""
    accepted = Accepted.of(found)
    start = "label of the first contact" if accepted.early else "first contact"
    return [
        *(
            row
            for name, kind in DETECTORS.items()
            for row in contact(name, kind.title, WINDOWS_RIGHT.get(name, "–"), accepted)
        ),
        Row(f"{start} to a complete 15 ms window, median", answer(lambda a: a.median), "ms"),
        Row("– samples before the second contact", answer(lambda a: a.before_second), "share"),
        Row(
            "– samples before it, at any time",
            of(lambda r: r.anytime, lambda a: a.before_second),
            "share",
        ),
    ]


def offset(number: Callable[[Offsets], Number]) -> Callable[[SubjectResults], Number]:
    """Of the time between the contacts."""
    return of(lambda r: r.offset_ms, number)


def order(number: Callable[[HardnessOrder], Number]) -> Callable[[SubjectResults], Number]:
    """Of the order of hardness."""
    return of(lambda r: r.hardness_order, number)


def left_out(model: str, score: str = "accuracy") -> Callable[[SubjectResults], Number]:
    """Score of the class of a material that was left out."""
    return order(lambda h: bounded(h.classes_left_out().get(model), score))


def pinches(results: SubjectResults) -> Number:
    """How many there are."""
    return results.data.pinches if results.data else None


OFFSETS = [
    Row("pinches", pinches, "count", "2500 + objects"),
    Row("first to second contact, mean", offset(lambda o: o.mean), "ms", "16.65 ms"),
    Row("first to second contact, SD", offset(lambda o: o.sd), "ms", "10.35 ms"),
    Row("second contact within 15 ms", offset(lambda o: o.share_below_15), "share"),
]
STIFFNESS = [
    *(
        row
        for name, kind in SCORED.items()
        for row in stiffness(name, kind.title, ACCURACY.get(name, "–"), ERROR.get(name, "–"))
    ),
    *(
        Row(f"8 unseen objects, in-context network: RMSE, {ms} ms", at_any_time(ms), "shore")
        for ms in ("3", "5", "15")
    ),
]
SPEED = [
    Row("load of the machine meanwhile", of(times("svm"), lambda t: t.load), "rate"),
    *(row for name, kind in SCORED.items() for row in speed(name, kind.title, TIME.get(name, "–"))),
    Row("the whole study", lambda r: r.seconds if isinstance(r, FirstSubject) else None, "s"),
]
#: What the README shows: no intervals, which stand beside the same numbers in the results.
HEADLINE: Rows = [
    Row(
        "samples for an estimate before the second contact; computing and cable left out",
        of(lambda r: r.anytime, lambda a: a.before_second),
        "share",
    ),
    Row(
        "8 unseen objects: RMSE, Shore A, 5 ms after contact",
        of(lambda r: r.anytime, lambda a: a.rmse.get("5")),
        "shore",
    ),
    Row(
        "– the published SVM, 15 ms after contact", lambda r: bounded(r.objects.get("svm"), "rmse"),
        "shore",
    ),
]  # fmt: skip
IMPACTS: Rows = [Row("impacts", pinches, "count")]
MATERIALS = [
    Row("materials", order(lambda h: h.spectral_centroid.n), "count"),
    Row(
        "Spearman, hardness and spectral centroid",
        order(lambda h: h.spectral_centroid.rho),
        "shore",
    ),
    Row("– its two-sided p", order(lambda h: h.spectral_centroid.p), "p"),
    Row("Spearman, SVM, material left out", order(lambda h: h.rho_left_out), "shore"),
    Row("accuracy of the class, SVM, material left out", left_out("svm"), "share"),
    Row("– peak alone, material left out", left_out("peak"), "share"),
    Row("– best constant prediction", left_out("svm", "best_constant"), "share"),
    Row(
        "– SVM, random folds",
        order(lambda h: bounded((h.random_folds or {}).get("svm"), "accuracy")),
        "share",
    ),
]
