"""Live session with its pipeline and its hand, for ``fc.live`` and the command ``live``."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

from firstcontact.contact import SLIP_DETECTORS, Detector, SlipDetector
from firstcontact.core import Calibration, InputError
from firstcontact.device import Source, TransportDelay
from firstcontact.grasp import (
    HANDS,
    POLICIES,
    Begins,
    Hand,
    HandError,
    find_hand,
    live_policy,
    make_hand,
    open_hand,
)
from firstcontact.streaming._grasping import Grasping
from firstcontact.streaming._pipeline import MeasureSpeed, Pipeline
from firstcontact.streaming._predictors import Predictor
from firstcontact.streaming._session import LiveSession


@contextmanager
def live_session(
    source: Source,
    detector: Detector,
    predictor: Predictor | None,
    calibration: Callable[[], Calibration | None],
    *,
    real_time: bool,
    hand: str | Hand | None = None,
    hand_port: str | None = None,
    policy: str | None = None,
    slip: str | None = None,
    recordings: Path = Path(),
    shape: str = "",
) -> Iterator[tuple[LiveSession, Grasping | None]]:
    """Open a live session in a context manager, which releases the hand at the end.

    Parameters
    ----------
    source
        Open source, at the rate of the detector.
    detector, predictor
        See :class:`Pipeline`.
    calibration
        Function that returns or measures the noise floors. It is called after all slow
        preparations, because samples arrive from then on.
    real_time
        True if samples come as fast as they were taken.
    hand, hand_port, policy, slip
        Names of the hand, its port, the grasp policy and the slip detector; the hand may also be an
        instance. None means no hand, no slip detector, or the default port and policy.
    recordings, shape
        See :class:`LiveSession`.

    Yields
    ------
    tuple of LiveSession and Grasping
        The session, and the event handler that drives its hand (None without a hand).

    Raises
    ------
    InputError
        The detector or model does not fit the source, or the hand fails.
    """
    from threadpoolctl import threadpool_limits

    layout, delay = source.descriptor.layout, source.descriptor.delay
    try:
        with ExitStack() as stack:
            # The matrices are small: threads that multiply them only wait for one another.
            stack.enter_context(threadpool_limits(1))
            pipeline = Pipeline(
                layout,
                detector,
                predictor,
                delay=delay,
                real_time=real_time,
                # A hand that predicts does not, and its predictions are compared with these.
                resettles=source.descriptor.predictor is None,
            )
            floors = calibration()
            pipeline.calibrate(floors)
            grasping = None
            if hand is not None:
                grasping = Grasping(
                    live_policy(policy or POLICIES.default),
                    stack.enter_context(open_hand(hand, hand_port, source=source)),
                    layout,
                    # At another speed than real time, no delay can be known.
                    transport=TransportDelay(layout.rate) if real_time else None,
                    slip=_slip_detector(slip),
                )
            pipeline.measure_speed = _speed_measurement(source, grasping)
            session = LiveSession(
                source,
                pipeline,
                () if grasping is None else (grasping,),
                recordings,
                floors,
                None if grasping is None else grasping.requests,
                shape,
            )
            yield session, grasping
    except HandError as error:  # also when it is released
        raise InputError(str(error), parameter="hand") from error


def _speed_measurement(source: Source, grasping: Grasping | None) -> MeasureSpeed | None:
    """Return the function that gives closing speeds, from a replay or a hand; None without."""
    if source.recorded:
        return lambda sample, epoch, host: source.closing_speed(sample, epoch)
    if grasping is None:
        return None
    hand, rate = grasping.hand, source.descriptor.layout.rate
    hand.closing_speed(0.0, math.nan)  # imports what it needs before the first contact
    return lambda sample, epoch, host: hand.closing_speed(sample / rate, host)


def check_hand(
    hand: str | Hand | None,
    hand_port: str | None = None,
    policy: str | None = None,
    slip: str | None = None,
    *,
    device: str,
    is_live: bool,
) -> None:
    """Refuse a hand that cannot be driven with these options or this source.

    Parameters
    ----------
    hand, hand_port, policy, slip
        See :func:`live_session`.
    device
        Name of the source.
    is_live
        False for recordings, and for samples at another speed than real time.

    Raises
    ------
    InputError
        The hand cannot be driven with these options or this source. The error names the parameter.
    """
    if policy is not None:
        POLICIES.find(policy)
    if slip is not None:
        _check_slip(slip, hand, policy or POLICIES.default)
    if hand is None:
        for parameter, value in (("policy", policy), ("hand_port", hand_port)):
            if value is not None:
                raise InputError(
                    "this option needs a hand: name a hand, or leave the option out",
                    parameter=parameter,
                )
        return
    kind = find_hand(hand)
    if isinstance(kind, Hand) and hand_port is not None:
        raise InputError(
            "this option needs the name of a hand, and an instance has its own port: leave it out",
            parameter="hand_port",
        )
    if kind.needs_live_samples(hand_port) and not is_live:
        instead = "" if kind.simulated_port is None else f", or the port {kind.simulated_port}"
        raise InputError(
            f"{kind.name} can be driven only by live samples in real time: use the hand "
            f"{HANDS.default}{instead}",
            parameter="hand",
        )
    if kind.of_source not in (None, device):
        raise InputError(
            f"{kind.name} works only with the source {kind.of_source!r}: open it, or name another "
            "hand",
            parameter="hand",
        )
    if isinstance(kind, type) and kind.of_source is None:
        make_hand(kind, hand_port)  # opens nothing: a missing package is reported now


def _check_slip(slip: str, hand: str | Hand | None, policy: str) -> None:
    """Refuse a slip detector unless the hand closes on request and the policy has a reflex."""
    SLIP_DETECTORS.find(slip)
    if hand is None or Begins.US not in find_hand(hand).begins:
        raise InputError(
            "this option needs a hand that closes on request: name one, or leave the option out",
            parameter="slip",
        )
    if not POLICIES.find(policy).has_reflex():
        raise InputError(
            f"the policy {policy} does not react to slips: leave the slip detector out, or name a "
            "policy with a slip reflex",
            parameter="slip",
        )


def _slip_detector(name: str | None) -> SlipDetector | None:
    if name is None:
        return None
    kind = SLIP_DETECTORS.find(name)
    with SLIP_DETECTORS.calling(name):
        return kind()
