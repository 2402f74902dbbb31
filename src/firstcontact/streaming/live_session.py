"""Opening of a live session: its source, model, noise floors, pipeline and hand."""

from __future__ import annotations

import logging
import math
import os
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import NamedTuple

from firstcontact.contact import Detector, general_detector
from firstcontact.core import (
    ArgumentError,
    Calibration,
    InputError,
    VibrationCalibration,
    fingertip_layout,
)
from firstcontact.core.calibration import given_calibration
from firstcontact.core.files import AnyPath, given_path
from firstcontact.core.physics import is_same_rate
from firstcontact.device import Source
from firstcontact.device.descriptor import DevicePredictor, skipped_model
from firstcontact.device.noise_floor import measure_noise
from firstcontact.device.replay import ReplaySource
from firstcontact.device.resampled import ResampledSource
from firstcontact.device.source import require_source
from firstcontact.grasp import Hand, HandError, Policy
from firstcontact.grasp.hand import Begins
from firstcontact.grasp.registry import find_hand
from firstcontact.models import Model, load_model
from firstcontact.models.anytime import Predictor
from firstcontact.streaming._pipeline import Pipeline
from firstcontact.streaming.events import Event
from firstcontact.streaming.grasping import Grasping
from firstcontact.streaming.hand_plan import HandPlan
from firstcontact.streaming.session import LiveSession
from firstcontact.streaming.translator import MeasureSpeed
from firstcontact.streaming.twin import default_model

_log = logging.getLogger("firstcontact.streaming")


@dataclass(frozen=True, kw_only=True, slots=True)
class SessionPlan:
    """Options of a live session. None lets the session choose.

    Attributes
    ----------
    model
        Model, or its folder.
    estimator
        Name of the estimator in the model that predicts.
    detector
        Contact detector that replaces the detector of the model.
    calibration
        Calibration with the noise floors of the sensors, or its file.
    real_time
        True if samples arrive in real time.
    hand
        Hand, its policy and its slip detector.
    recordings
        Folder for recordings.
    shape
        Shape of all objects: "flat", or a radius in mm; "" if unknown.
    """

    model: Model | AnyPath | None = None
    estimator: str | None = None
    detector: Detector | None = None
    calibration: Calibration | AnyPath | None = None
    real_time: bool | None = None
    hand: HandPlan = field(default_factory=HandPlan)
    recordings: Path = Path()
    shape: str = ""


class _Choice(NamedTuple):
    """Model, contact detector and predictor of a session. Each is None if the session has none."""

    model: Model | None
    detector: Detector | None
    predictor: Predictor | None


@contextmanager
def live_session(
    source: Source,
    plan: SessionPlan,
    *,
    measure: Callable[[Source], Calibration] = measure_noise,
    opens: bool = False,
    notify: Callable[[str], None] = _log.info,
) -> Iterator[LiveSession]:
    """Open a live session as a context manager, which closes the session's hand at the end.

    ``measure`` measures the noise floors if they are unknown, ``opens`` opens the source, too, and
    ``notify`` gets remarks for the user. Raise InputError if the options do not fit together.
    """
    from threadpoolctl import threadpool_limits

    real_time = source.speed == 1.0 if plan.real_time is None else plan.real_time
    plan.hand.check(source.name, is_live=real_time and not source.is_replay)
    floors = given_calibration(plan.calibration)
    model = _model(plan, source)
    try:
        with ExitStack() as stack:
            if opens:
                stack.enter_context(source)
            # The matrices are small: threads that multiply them only wait for one another.
            stack.enter_context(threadpool_limits(1))
            choice = _choose(plan, model, source)
            for line in _remarks(source, choice, plan.estimator, is_given=plan.model is not None):
                notify(line)
            used_source = _at_rate(source, choice, notify)
            pipeline = _pipeline(source, used_source, choice, real_time=real_time)
            floors = floors or _device_floors(source.descriptor.predictor)
            if floors is None:
                # Without noise floors, each closing of a recording is an epoch.
                recorded = used_source.is_replay
                floors = used_source.calibration if recorded else measure(used_source)
            pipeline.calibrate(floors)
            if isinstance(source, ReplaySource):
                pipeline.follow(source.recording)
            grasping = plan.hand.open(stack, used_source, choice.predictor, real_time=real_time)
            pipeline.translator.measure_speed = _speed_measurement(used_source, grasping)
            yield LiveSession(
                used_source,
                pipeline,
                grasping,
                recordings=plan.recordings,
                calibration=floors,
                shape=plan.shape,
                model=choice.model,
                notify=notify,
            )
    except HandError as error:  # also when it is released
        raise ArgumentError(str(error), parameter="hand") from error


def _model(plan: SessionPlan, source: Source) -> Model:
    """Return the model that the plan names, or the default model for the source."""
    model = plan.model
    if isinstance(model, str | os.PathLike):
        model = load_model(model, plan.detector)
    elif model is None:
        model = default_model(source)
    # The detector decides which estimators fit.
    return model if plan.detector is None else replace(model, detector=plan.detector)


def _choose(plan: SessionPlan, model: Model, source: Source) -> _Choice:
    """Return the model, detector and predictor of a session.

    If the device predicts by itself, a model predicts only if the user names it.
    """
    is_own = source.descriptor.predictor is None or model.folder is not None
    if plan.model is None and not is_own:
        return _Choice(None, plan.detector, None)
    predictor = None
    if model.predictors:
        fitted = None if model.detector is None else model.detector.rate
        predictor = model.default(plan.estimator, fitted)
    return _Choice(model, model.own_detector, predictor)


def _pipeline(opened: Source, source: Source, choice: _Choice, *, real_time: bool) -> Pipeline:
    """Return the pipeline of a session, which processes the samples of ``source``.

    ``source`` is the opened source itself, or resamples it.
    """
    layout = source.descriptor.layout
    pipeline = Pipeline(
        layout,
        choice.detector or general_detector(layout),
        choice.predictor,
        delay=source.descriptor.delay,
        real_time=real_time,
        # A hand that predicts does not, and its predictions are compared with these.
        resettles=opened.descriptor.predictor is None,
    )
    if choice.model is not None and choice.predictor is not None:
        pipeline.translator.is_foreign = choice.model.is_foreign(layout)
    name = "none" if choice.predictor is None else choice.predictor.name
    _log.info("live at %g Hz: detector %s, predictor %s", layout.rate, pipeline.detector, name)
    return pipeline


def _remarks(
    source: Source, choice: _Choice, estimator: str | None, *, is_given: bool
) -> Iterator[str]:
    model, _, predictor = choice
    if model is not None and model.folder is None and not is_given:
        yield (
            "no model was given, so the package's model predicts. Its intervals are wide, because "
            "it is not adapted to this hand: `firstcontact adapt` does so with a few pinches"
        )
    elif model is not None and predictor is not None:
        yield _who_predicts(model, predictor, estimator)
    device, slot = source.descriptor.predictor, source.descriptor.model_slot
    if device is not None:
        yield _device_model(device, model if is_given else None, estimator)
    if slot is not None and slot.fault:
        yield skipped_model(slot, device is not None)


def _who_predicts(model: Model, predictor: Predictor, estimator: str | None) -> str:
    default = model.predictors[0]
    if estimator is None and default.name != predictor.name:
        return (
            f"estimates come from {predictor.name}, because {default.name} needs {default.rate:g} "
            f"Hz and the detector another rate: train both together to use {default.name}"
        )
    fitting = [p.name for p in model.predictors if is_same_rate(p.rate, predictor.rate)]
    others = [name for name in dict.fromkeys(fitting) if name != predictor.name]
    choice = f": add --estimator {' or '.join(others)} for others" if others else ""
    return f"estimates come from {predictor.name}{choice}"


def _device_model(device: DevicePredictor, model: Model | None, estimator: str | None) -> str:
    from firstcontact.export.hand_image import hand_image

    line = f"the device predicts by itself, with the model {device.model}"
    folder = None if model is None else model.folder
    if folder is None:
        return f"{line}: name the folder that it was flashed from with --model to check it"
    try:
        digest = hand_image(folder, estimator=estimator).digest
    except InputError:  # the folder holds no model for a device
        digest = "another"
    if digest == device.model:
        return f"{line}, the same as in {folder}: its predictions are checked"
    return f"{line}, but {folder} holds {digest}: its predictions are compared, and will differ"


def _at_rate(source: Source, choice: _Choice, notify: Callable[[str], None]) -> Source:
    stated = source.descriptor.layout.rate
    trained = None if choice.detector is None else choice.detector.rate
    rate = trained or (stated if choice.predictor is None else choice.predictor.rate)
    # A trained detector takes its own rate only. Without one, a rate that differs by no more than
    # a clock's error counts as the same.
    if stated == rate or (trained is None and is_same_rate(stated, rate)):
        return source
    notify(
        f"{source.name} sends {stated:g} samples a second, but the model needs {rate:g}, so the "
        "samples are resampled, also in recordings"
    )
    return ResampledSource(source, rate)


def _device_floors(device: DevicePredictor | None) -> Calibration | None:
    """Return the noise floors that a device reports with its predictor; None if it has none."""
    if device is None or len(device.floors) < 2 or not min(device.floors) > 0:
        return None
    pairs = zip(fingertip_layout().vibration_fingers, device.floors, strict=True)
    return Calibration(tuple(VibrationCalibration(f, noise) for f, noise in pairs))


def _speed_measurement(source: Source, grasping: Grasping | None) -> MeasureSpeed | None:
    if source.is_replay:
        return lambda sample, epoch, host: source.closing_speed(sample, epoch)
    if grasping is None:
        return None
    hand, rate = grasping.hand, source.descriptor.layout.rate
    hand.closing_speed(0.0, math.nan)  # imports what it needs before the first contact
    return lambda sample, epoch, host: hand.closing_speed(sample / rate, host)


def check_limits(seconds: float | None, pinches: int | None) -> None:
    """Raise ArgumentError if the duration, s, or the number of pinches is not above 0."""
    for name, noun, bound in (
        ("seconds", "the duration", seconds),
        ("pinches", "the number of pinches", pinches),
    ):
        if bound is not None and not bound > 0:
            raise ArgumentError(f"{noun} is {bound:g}: give a number above 0", parameter=name)


def live(
    source: Source,
    model: Model | AnyPath | None = None,
    *,
    calibration: Calibration | AnyPath | None = None,
    shape: str | float | None = None,
    estimator: str | None = None,
    hand: str | Hand | None = None,
    hand_port: str | None = None,
    policy: str | type[Policy] | Policy | None = None,
    record: AnyPath | None = None,
    seconds: float | None = None,
    pinches: int | None = None,
    real_time: bool | None = None,
) -> Iterator[Event]:
    """Read samples from a source, and yield contacts, stiffness estimates and finished pinches.

    Parameters
    ----------
    source
        A source from :func:`open`. It is closed when the iteration ends. Its samples are resampled
        if the model needs another rate.
    model
        Model or its folder. By default a model for the simulated hand, no model for a device that
        predicts by itself, and for other sources the package's model. That one is not adapted to
        your hand and sensors, so its prediction intervals are wide.
    calibration
        Calibration with the sensors' noise at rest, or its file. By default the noise is measured
        when the session starts; keep the hand still meanwhile.
    shape
        Shape of the touched surface if all objects share it: "flat", or its radius in mm.
    estimator
        Name of the estimator in the model that predicts, such as "svm". By default the first of
        ``model.estimators``.
    hand, hand_port, policy
        Hand to drive, its port, and the grasp policy (code that decides how the hand closes). The
        hand is a name, or an instance of your own subclass of :class:`firstcontact.grasp.Hand`,
        not open yet. The policy is a name, your own subclass of
        :class:`firstcontact.grasp.Policy`, or an instance of it. The hand is always released at
        the end, also after an error (see :class:`firstcontact.grasp.SafeHand`).
    record
        Folder in which a recording of all samples is written.
    seconds, pinches
        Stop after this time, s, or after this number of pinches. By default do not stop.
    real_time
        Set False for a source that runs faster or slower than real time without reporting it.
        ``Estimate.in_time`` is then None.

    Yields
    ------
    Event
        An event, such as :class:`ContactEvent`, :class:`Estimate` or :class:`PinchDone`.

    Raises
    ------
    InputError
        The model does not fit the source, the source fails, or the recording cannot be written.

    Examples
    --------
    >>> import firstcontact as fc
    >>> with fc.open("twin", speed=8.0) as source:
    ...     events: list[fc.Event] = list(fc.live(source, pinches=1))
    >>> finals = [event for event in events if isinstance(event, fc.Estimate) and event.final]
    >>> pinches = [event for event in events if isinstance(event, fc.PinchDone)]
    >>> len(pinches)
    1
    """
    require_source(source)
    check_limits(seconds, pinches)
    if hand is not None and (kind := find_hand(hand)).begins is Begins.US:
        raise ArgumentError(
            f"{kind.name} closes only on request, and this function cannot send requests: run "
            f"`firstcontact live --hand {kind.name}` instead",
            parameter="hand",
        )
    plan = SessionPlan(
        model=model,
        estimator=estimator,
        calibration=calibration,
        real_time=real_time,
        hand=HandPlan(hand, hand_port, policy),
        recordings=Path() if record is None else given_path(record, "record"),
        shape="" if shape is None else str(shape),
    )
    with live_session(source, plan) as session:
        if record is not None:
            session.start_recording()
        for event in session.events(seconds=seconds, pinches=pinches):
            if session.recording.failed:
                break
            yield event
        if session.recording.failed:
            raise ArgumentError(session.recording.failed, parameter="record")
