"""Scores of contact detectors against the true contacts, for the study part ``contacts``."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from firstcontact.contact import Detector
from firstcontact.contact.closing_start import cut_closings
from firstcontact.contact.contacts import PinchDecisions, judge_pinch
from firstcontact.contact.detector import WindowDecisions
from firstcontact.core import ArgumentError, Contact, Dataset, Record
from firstcontact.signal import samples_in
from firstcontact.signal.resampling import lookahead

#: Age up to which a contact need not show in a window, s.
GUARD = 0.001
#: Time between two counted windows, s, as published.
WINDOW_STEP = 0.003
#: Largest distance of a first trigger from the strip's contact, s.
TOLERANCE = 0.003
#: Time after a known contact up to which all windows are judged, s. The contact window of a score
#: needs :data:`GUARD` plus a detector's step.
JUDGED = 0.035


class Delays(Record, frozen=True, kw_only=True):
    """Median and 95th percentile of the delays from a contact to its detection, ms."""

    median: float
    p95: float


class DetectionScores(Record, frozen=True, kw_only=True):
    """Scores of a detector on the pinches whose true first contact is known."""

    n: int
    #: Pinches without a known first contact, which are not in ``n``.
    left_out: int
    #: Pinches whose contact came before any window could detect it.
    too_soon: int
    windows: int
    quiet_windows: int
    #: Shares of right decisions. Most windows are quiet: read the first with the next two.
    window_accuracy: float | None = None
    quiet_windows_silent: float | None = None
    contact_windows_found: float | None = None
    #: Share of pinches whose first trigger is on the touching finger and placed within 3 ms.
    pinch_success: float
    #: Share of these successes whose decision came 0 to 3 ms after the contact, of all pinches.
    decided_within_3_ms: float
    #: Pinches whose first trigger is placed more than 3 ms too early, on the wrong finger, or more
    #: than 3 ms too late, and pinches without any trigger.
    false_alarms: int
    wrong_finger: int
    late: int
    misses: int
    #: Runs of quiet windows that fire, per finger, while the steady state follows a quieter motor.
    false_alarms_per_minute: float | None = None
    #: Time from the contact to the decision, with the look-ahead of the resampler. First triggers
    #: on the wrong finger, and those that are placed or decided too early, do not count.
    delay_ms: Delays | None = None
    lookahead_ms: float | None = None

    @property
    def median_delay(self) -> float | None:
        return None if self.delay_ms is None else self.delay_ms.median


def _merge_looks(decisions: WindowDecisions, looks: int) -> WindowDecisions:
    """Merge each group of ``looks`` consecutive decisions into one.

    The merged decision fires if any decision of the group fires.
    """
    n = len(decisions.ends) // looks
    if looks == 1 or not n:
        return decisions
    ends = decisions.ends[: n * looks].reshape(n, looks)[:, -1]
    fired = np.asarray(decisions.fired[: n * looks].reshape(n, looks, -1).any(axis=1))
    return WindowDecisions(ends, fired, np.where(fired, 0, -1))


@dataclass(slots=True)
class _Counts:
    too_soon: int = 0
    quiet: int = 0
    quiet_right: int = 0
    contact: int = 0
    contact_right: int = 0
    seconds: float = 0.0
    alarms: int = 0

    def add(
        self, windows: WindowDecisions, column: int, truth: int, early: int, guard: int, step: int
    ) -> None:
        if not len(windows.ends) or truth <= windows.ends[0] - step:
            self.too_soon += 1
            return
        fired = windows.fired[windows.ends < truth - early]
        self.quiet += fired.size
        self.quiet_right += int((~fired).sum())
        shows = np.flatnonzero(windows.ends >= truth + guard - 1)
        if len(shows):
            self.contact += 1
            self.contact_right += int(windows.fired[shows[0], column])

    def add_alarms(self, windows: WindowDecisions, truth: int, early: int, seconds: float) -> None:
        fired = windows.fired[windows.ends < truth - early]
        starts = fired.copy()
        starts[1:] &= ~fired[:-1]
        self.alarms += int(starts.sum())
        self.seconds += len(fired) * seconds


def score_detector(detector: Detector, dataset: Dataset) -> DetectionScores:
    return score_decisions(judge_pinches(detector, cut_closings(dataset)), dataset, detector.step)


def judge_pinches(detector: Detector, dataset: Dataset) -> list[PinchDecisions]:
    """Run the detector on each pinch. Return one record of decisions per pinch."""
    margin = samples_in(JUDGED, dataset.layout.rate)
    return [
        judge_pinch(detector, pinch, 0 if pinch.first is None else pinch.first.sample + margin)
        for pinch in dataset.pinches
    ]


def score_decisions(
    decisions: Sequence[PinchDecisions],
    dataset: Dataset,
    step: float,
    early: float = 0.0,
) -> DetectionScores:
    """Score the decisions of a detector on windows that are ``step`` s apart.

    Labels of contacts may be up to ``early`` s too late. Raise InputError if no pinch has a label.
    """
    counts = _Counts()
    outcomes = dict.fromkeys(("success", "false_alarms", "wrong_finger", "late", "misses"), 0)
    delays: list[float] = []
    decided = 0
    waited = resampler_lookahead(dataset)
    judged_pinches = [
        (p, p.first, d)
        for p, d in zip(dataset.pinches, decisions, strict=True)
        if p.first is not None
    ]
    if not judged_pinches:
        raise ArgumentError("no pinch has a known first contact to score detection: label contacts")
    for pinch, truth, decision in judged_pinches:
        rate = pinch.layout.rate
        fingers = pinch.layout.vibration_fingers
        if truth.finger in fingers:
            look = max(1, samples_in(step, rate))
            looks = max(1, samples_in(WINDOW_STEP, rate) // look)
            step_samples, early_samples = looks * look, samples_in(early, rate)
            counts.add(
                _merge_looks(decision.fixed_windows, looks),
                fingers.index(truth.finger),
                truth.sample,
                early_samples,
                samples_in(GUARD, rate),
                step_samples,
            )
            counts.add_alarms(
                _merge_looks(decision.windows, looks),
                truth.sample,
                early_samples,
                step_samples / rate,
            )
        first = decision.first
        became = outcome(first, truth, rate, early)
        outcomes[became] += 1
        if first is not None and right_and_not_early(first, truth, rate, early):
            delay = (first.decided - truth.sample) / rate + waited
            delays.append(1e3 * delay)
            decided += became == "success" and delay <= TOLERANCE
    return DetectionScores(
        n=len(judged_pinches),
        left_out=len(dataset) - len(judged_pinches),
        too_soon=counts.too_soon,
        quiet_windows=counts.quiet,
        windows=counts.quiet + counts.contact,
        window_accuracy=_share(
            counts.quiet_right + counts.contact_right, counts.quiet + counts.contact
        ),
        quiet_windows_silent=_share(counts.quiet_right, counts.quiet),
        contact_windows_found=_share(counts.contact_right, counts.contact),
        pinch_success=outcomes["success"] / len(judged_pinches),
        decided_within_3_ms=decided / len(judged_pinches),
        false_alarms=outcomes["false_alarms"],
        wrong_finger=outcomes["wrong_finger"],
        late=outcomes["late"],
        misses=outcomes["misses"],
        false_alarms_per_minute=(60.0 * counts.alarms / counts.seconds if counts.seconds else None),
        delay_ms=quantiles(np.array(delays)) if delays else None,
        lookahead_ms=1e3 * waited if waited else None,
    )


def resampler_lookahead(dataset: Dataset) -> float:
    """Return the look-ahead of the filter that resampled a dataset, s, or 0 without resampling."""
    rate = dataset.layout.rate
    return lookahead(dataset.recorded_rate or rate, rate)


def right_and_not_early(contact: Contact, truth: Contact, rate: float, early: float) -> bool:
    """Return True if a detected contact is on the correct finger and not too early.

    The label ``truth`` may be up to ``early`` s too late. ``rate`` is the sample rate, Hz.
    """
    placed = (contact.sample - truth.sample) / rate
    return (
        contact.finger is truth.finger
        and placed >= -(early + TOLERANCE)
        # A decision before the contact is right only by chance.
        and contact.decided >= truth.sample - samples_in(early, rate)
    )


def outcome(contact: Contact | None, truth: Contact, rate: float, early: float) -> str:
    """Return "success" for a correctly detected contact, otherwise the name of the failure.

    The label ``truth`` may be up to ``early`` s too late. ``rate`` is the sample rate, Hz.
    """
    if contact is None:
        return "misses"
    late = (contact.sample - truth.sample) / rate
    if late < -(early + TOLERANCE):
        return "false_alarms"
    if late > TOLERANCE:
        return "late"
    return "success" if contact.finger is truth.finger else "wrong_finger"


def _share(part: int, total: int) -> float | None:
    return part / total if total else None


def quantiles(delays: NDArray[np.float64]) -> Delays:
    return Delays(median=float(np.median(delays)), p95=float(np.percentile(delays, 95)))
