"""Public functions for live sessions: open a source, and follow contacts and estimates."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from firstcontact.core import ArgumentError
from firstcontact.core.files import given_path

if TYPE_CHECKING:
    from firstcontact.core import Calibration
    from firstcontact.device import Source
    from firstcontact.grasp import Hand, Policy
    from firstcontact.models import Model
    from firstcontact.streaming import Event


def open(
    device: str | os.PathLike[str] = "twin",
    *,
    speed: float = 1.0,
    condition: str = "paper-rig",
    seed: int = 0,
    objects: str = "paper",
) -> Source:
    """Open a live source of samples. Use it in a ``with`` statement, which closes it.

    Parameters
    ----------
    device
        "twin" for the simulated hand, the name of a serial port, "audio" for the sound input,
        "lsl:NAME" for an LSL stream, "csv:PORT" for a serial port that sends lines of numbers, or
        the path of a recording (.mcap) to replay.
    speed
        Speed of the simulated hand or of a replay, as a multiple of real time.
    condition, seed
        Variation of the simulated hand ("paper-rig" or "everyday"), and its random seed.
    objects
        Objects that the simulated hand grasps: "paper", "household", or the name of one object.

    Raises
    ------
    InputError
        The device does not exist, or does not accept these parameters.

    Examples
    --------
    >>> import firstcontact as fc
    >>> def received(source: fc.Source) -> int:
    ...     health: fc.Health = source.health
    ...     return health.samples
    >>> with fc.open("twin", speed=4.0) as source:
    ...     arrivals = source.read(5.0, least=100)
    ...     samples = received(source)
    >>> samples >= sum(len(arrival.block.data) for arrival in arrivals) > 0
    True
    """
    from firstcontact.device import open_source

    return open_source(device, speed=speed, condition=condition, seed=seed, objects=objects)


def live(
    source: Source,
    model: Model | str | os.PathLike[str] | None = None,
    *,
    calibration: Calibration | str | os.PathLike[str] | None = None,
    shape: str | float | None = None,
    estimator: str | None = None,
    hand: str | Hand | None = None,
    hand_port: str | None = None,
    policy: str | type[Policy] | Policy | None = None,
    record: str | os.PathLike[str] | None = None,
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
    from firstcontact.device.source import require_source
    from firstcontact.grasp.hand import Begins
    from firstcontact.grasp.registry import find_hand
    from firstcontact.streaming.hand_plan import HandPlan
    from firstcontact.streaming.live_session import SessionPlan, live_session

    require_source(source)
    for name, noun, bound in (
        ("seconds", "the duration", seconds),
        ("pinches", "the number of pinches", pinches),
    ):
        if bound is not None and not bound > 0:
            raise ArgumentError(f"{noun} is {bound:g}: give a number above 0", parameter=name)
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
