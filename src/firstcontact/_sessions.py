"""Public functions for live sessions: open a source, and follow contacts and estimates."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from firstcontact.core import InputError
from firstcontact.core.files import given_path

if TYPE_CHECKING:
    from firstcontact.core import Calibration
    from firstcontact.device import Source
    from firstcontact.grasp import Hand
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
    """Open a source of samples, for use in a ``with`` statement.

    Parameters
    ----------
    device
        "twin" for the simulated hand, a serial port, "audio", "lsl:NAME", "csv:PORT", or the
        path of a recording (.mcap).
    speed
        Speed of the twin or of a recording, as a multiple of real time.
    condition, seed
        Condition and random seed of the twin.
    objects
        Objects that the twin picks up: the set "paper" or "household", or the name of one object.

    Raises
    ------
    InputError
        The device does not exist, or cannot be used with these parameters.

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
    policy: str | None = None,
    record: str | os.PathLike[str] | None = None,
    seconds: float | None = None,
    pinches: int | None = None,
    real_time: bool | None = None,
) -> Iterator[Event]:
    """Follow a source: yield contacts, estimates and finished pinches as they happen.

    Parameters
    ----------
    source
        An open source. It is closed when the iteration ends. Its samples are resampled if the model
        needs another rate.
    model
        Model or its folder. By default the twin's own model for the twin, and no model for a device
        that predicts by itself. For other sources it is the model of the package, which is not
        adapted to your rig, so its intervals are wide.
    calibration
        Calibration with the noise floors, or its file. By default they are measured first; keep the
        hand still meanwhile.
    shape
        Shape at the contact if it is the same for all objects: "flat", or a radius in mm.
    estimator
        Name of the estimator that predicts, such as "svm". By default the first of
        ``model.estimators``. ``Estimate.model`` names the estimator.
    hand, hand_port, policy
        Hand to drive, its port, and the grasp policy. The hand is a name, or an instance of your
        own subclass of :class:`firstcontact.grasp.Hand` that is not open yet. It is wrapped in
        :class:`firstcontact.grasp.SafeHand`, so it is always released at the end, also after an
        error.
    record
        Folder for a recording of all samples.
    seconds, pinches
        End after this time, s, or after this number of pinches.
    real_time
        Set False for a source that runs faster or slower than real time without reporting it.
        Estimates are then not rated as in time or too late.

    Yields
    ------
    Event
        See :mod:`firstcontact.streaming`.

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
    from firstcontact.streaming.live_session import live_session

    require_source(source)
    for name, noun, bound in (
        ("seconds", "the duration", seconds),
        ("pinches", "the number of pinches", pinches),
    ):
        if bound is not None and not bound > 0:
            raise InputError(f"{noun} is {bound:g}: give a number above 0", parameter=name)
    if hand is not None and (kind := find_hand(hand)).begins is Begins.US:
        raise InputError(
            f"{kind.name} closes only on request, and this function cannot send requests: run "
            f"`firstcontact live --hand {kind.name}` instead",
            parameter="hand",
        )
    with live_session(
        source,
        model,
        estimator=estimator,
        calibration=calibration,
        real_time=real_time,
        hand=hand,
        hand_port=hand_port,
        policy=policy,
        recordings=Path() if record is None else given_path(record, "record"),
        shape="" if shape is None else str(shape),
    ) as session:
        if record is not None:
            session.start_recording()
        for event in session.events(seconds=seconds, pinches=pinches):
            if session.recording.failed:
                break
            yield event
        if session.recording.failed:
            raise InputError(session.recording.failed, parameter="record")
