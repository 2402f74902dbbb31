"""Assembly of a live session: source, model, noise floors, pipeline and hand."""

from __future__ import annotations

import logging
import math
import os
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from pathlib import Path

from firstcontact.contact import SLIP_DETECTORS, Detector, SlipDetector, general_detector
from firstcontact.core import (
    ArgumentError,
    Calibration,
    InputError,
    VibrationCalibration,
    fingertip_layout,
)
from firstcontact.core.calibration import given_calibration
from firstcontact.core.files import AnyPath
from firstcontact.core.physics import is_same_rate
from firstcontact.core.quantity import SHORE_A
from firstcontact.device import Source
from firstcontact.device.clock import TransportDelay
from firstcontact.device.descriptor import DevicePredictor, skipped_model
from firstcontact.device.noise_floor import measure_noise
from firstcontact.device.replay import ReplaySource
from firstcontact.device.resampled import ResampledSource
from firstcontact.grasp import HANDS, POLICIES, Hand, HandError, Policy, open_hand
from firstcontact.grasp.hand import Begins
from firstcontact.grasp.registry import find_hand, find_policy, live_policy, make_hand
from firstcontact.models import Model, load_model
from firstcontact.models.anytime import Predictor
from firstcontact.streaming._pipeline import MeasureSpeed, Pipeline
from firstcontact.streaming.grasping import Grasping
from firstcontact.streaming.session import LiveSession
from firstcontact.streaming.twin import default_model

_log = logging.getLogger("firstcontact.streaming")


@contextmanager
def live_session(
    source: Source,
    model: Model | AnyPath | None = None,
    *,
    estimator: str | None = None,
    detector: Detector | None = None,
    calibration: Calibration | AnyPath | None = None,
    measure: Callable[[Source], Calibration] = measure_noise,
    real_time: bool | None = None,
    opens: bool = False,
    hand: str | Hand | None = None,
    hand_port: str | None = None,
    policy: str | type[Policy] | Policy | None = None,
    slip: str | None = None,
    recordings: Path = Path(),
    shape: str = "",
    notify: Callable[[str], None] = _log.info,
) -> Iterator[LiveSession]:
    """Open a live session in a context manager, which releases the hand at the end."""
    from threadpoolctl import threadpool_limits

    if real_time is None:
        real_time = source.speed == 1.0
    is_live = real_time and not source.recorded
    _check_hand(hand, hand_port, policy, slip, source.name, is_live=is_live)
    floors = given_calibration(calibration)
    is_given = model is not None
    if isinstance(model, str | os.PathLike):
        model = load_model(model, detector)
    elif model is None:
        model = default_model(source)
    if detector is not None:
        model = replace(model, detector=detector)  # it decides which estimators fit
    try:
        with ExitStack() as stack:
            if opens:
                stack.enter_context(source)
            # The matrices are small: threads that multiply them only wait for one another.
            stack.enter_context(threadpool_limits(1))
            device = source.descriptor.predictor
            used = model if is_given or device is None or model.folder is not None else None
            predictor = None
            if used is not None and used.predictors:
                fitted = None if used.detector is None else used.detector.rate
                predictor = used.default(estimator, fitted)
            detector = detector if used is None else used.own_detector
            for line in _remarks(source, used, predictor, estimator, is_given=is_given):
                notify(line)
            opened, source = source, _at_rate(source, detector, predictor, notify)
            layout = source.descriptor.layout
            pipeline = Pipeline(
                layout,
                detector or general_detector(layout),
                predictor,
                delay=source.descriptor.delay,
                real_time=real_time,
                # A hand that predicts does not, and its predictions are compared with these.
                resettles=device is None,
            )
            if used is not None and predictor is not None:
                pipeline.is_foreign = used.is_foreign(layout)
            floors = floors or _device_floors(device)
            if floors is None:
                # Without noise floors, each closing of a recording is an epoch.
                floors = source.calibration if source.recorded else measure(source)
            pipeline.calibrate(floors)
            if isinstance(opened, ReplaySource):
                pipeline.follow(opened.recording)
            grasping = None
            if hand is not None:
                made = live_policy(policy or POLICIES.default)
                _check_quantity(made, predictor)
                grasping = Grasping(
                    made,
                    stack.enter_context(open_hand(hand, hand_port, source=source)),
                    layout,
                    # At another speed than real time, no delay can be known.
                    transport=TransportDelay(layout.rate) if real_time else None,
                    slip=None if slip is None else _slip_detector(slip),
                )
            pipeline.measure_speed = _speed_measurement(source, grasping)
            name = "none" if predictor is None else predictor.name
            _log.info(
                "live at %g Hz: detector %s, predictor %s", layout.rate, pipeline.detector, name
            )
            yield LiveSession(
                source,
                pipeline,
                grasping,
                recordings=recordings,
                calibration=floors,
                shape=shape,
                model=used,
                notify=notify,
            )
    except HandError as error:  # also when it is released
        raise ArgumentError(str(error), parameter="hand") from error


def _check_quantity(policy: Policy, predictor: Predictor | None) -> None:
    """Refuse a policy that uses estimates with a model that does not predict Shore A."""
    if policy.deadline is not None and predictor and predictor.quantity is not SHORE_A:
        raise ArgumentError(
            f"{policy.name} uses estimates in Shore A, but the model predicts "
            f"{predictor.quantity.axis}: choose a policy without estimates, or another model",
            parameter="policy",
        )


def _remarks(
    source: Source,
    model: Model | None,
    predictor: Predictor | None,
    estimator: str | None,
    *,
    is_given: bool,
) -> Iterator[str]:
    if model is not None and model.folder is None and not is_given:
        yield (
            "no --model: the model of the package predicts, which does not know this rig. Its "
            "intervals are wide, and `firstcontact adapt` narrows them with a few pinches of blocks"
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
            f"{predictor.name} predicts, because {default.name} takes {default.rate:g} samples a "
            f"second and the detector another number: train both together to use {default.name}"
        )
    fitting = [p.name for p in model.predictors if is_same_rate(p.rate, predictor.rate)]
    others = [name for name in dict.fromkeys(fitting) if name != predictor.name]
    choice = f"; to change that, add --estimator {' or '.join(others)}" if others else ""
    return f"{predictor.name} predicts{choice}"


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


def _at_rate(
    source: Source,
    detector: Detector | None,
    predictor: Predictor | None,
    notify: Callable[[str], None],
) -> Source:
    stated = source.descriptor.layout.rate
    trained = None if detector is None else detector.rate
    rate = trained or (stated if predictor is None else predictor.rate)
    # A trained detector takes its own rate only. Without one, a rate that differs by no more than
    # a clock's error counts as the same.
    if stated == rate or (trained is None and is_same_rate(stated, rate)):
        return source
    notify(
        f"{source.name} sends {stated:g} samples a second and the model takes {rate:g}: they are "
        "resampled, also in recordings"
    )
    return ResampledSource(source, rate)


def _device_floors(device: DevicePredictor | None) -> Calibration | None:
    """Return the noise floors that a device reports, for the host; None if it reports none."""
    if device is None or len(device.floors) < 2 or not min(device.floors) > 0:
        return None
    pairs = zip(fingertip_layout().vibration_fingers, device.floors, strict=True)
    return Calibration(tuple(VibrationCalibration(f, noise) for f, noise in pairs))


def _speed_measurement(source: Source, grasping: Grasping | None) -> MeasureSpeed | None:
    if source.recorded:
        return lambda sample, epoch, host: source.closing_speed(sample, epoch)
    if grasping is None:
        return None
    hand, rate = grasping.hand, source.descriptor.layout.rate
    hand.closing_speed(0.0, math.nan)  # imports what it needs before the first contact
    return lambda sample, epoch, host: hand.closing_speed(sample / rate, host)


def _check_hand(
    hand: str | Hand | None,
    hand_port: str | None,
    policy: str | type[Policy] | Policy | None,
    slip: str | None,
    device: str,
    *,
    is_live: bool,
) -> None:
    """Refuse a hand that cannot be driven with these options or this source."""
    if policy is not None:
        find_policy(policy)
    if slip is not None:
        _check_slip(slip, hand, find_policy(policy or POLICIES.default))
    if hand is None:
        if policy is not None or hand_port is not None:
            noun, parameter = ("port", "hand_port") if policy is None else ("policy", "policy")
            raise ArgumentError(
                f"the {noun} has no effect without a hand: name a hand, or leave the {noun} out",
                parameter=parameter,
            )
        return
    kind = find_hand(hand)
    if isinstance(kind, Hand) and hand_port is not None:
        raise ArgumentError(
            "a hand that is given as an object has its own port: leave the port out",
            parameter="hand_port",
        )
    if kind.needs_live_samples(hand_port) and not is_live:
        port = kind.simulated_port
        instead = "" if port is None else f", or hand_port={port!r}"
        raise ArgumentError(
            f"the hand {kind.name!r} moves, so it needs a source with live samples: use the hand "
            f"{HANDS.default!r}{instead} with a recording",
            parameter="hand",
        )
    if kind.of_source not in (None, device):
        raise ArgumentError(
            f"the hand {kind.name!r} works only with the source {kind.of_source!r}: use this "
            "source or another hand",
            parameter="hand",
        )
    if isinstance(kind, type) and kind.of_source is None:
        make_hand(kind, hand_port)  # opens nothing: a missing package is reported now


def _check_slip(slip: str, hand: str | Hand | None, policy: type[Policy] | Policy) -> None:
    """Refuse a slip detector unless the hand closes on request and the policy has a reflex."""
    SLIP_DETECTORS.find(slip)
    if hand is None or Begins.US not in find_hand(hand).begins:
        raise ArgumentError(
            "only a hand that closes on request can react to slips: name such a hand, or leave the "
            "slip detector out",
            parameter="slip",
        )
    if not policy.has_reflex():
        raise ArgumentError(
            f"the policy {policy.name} does not react to slips: leave the slip detector out, or "
            "name a policy with a slip reflex",
            parameter="slip",
        )


def _slip_detector(name: str) -> SlipDetector:
    kind = SLIP_DETECTORS.find(name)
    with SLIP_DETECTORS.calling(name):
        return kind()
