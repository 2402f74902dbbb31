"""Live events as JSON: one object each, the same for every program that listens."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

from firstcontact.core import Contact, Finger
from firstcontact.device import Descriptor, DeviceContact, DevicePrediction, Health
from firstcontact.models import in_words
from firstcontact.recording import Marker
from firstcontact.streaming._events import (
    Answer,
    Armed,
    Case,
    Estimated,
    Event,
    FromHand,
    HandAsked,
    HandPinch,
    PinchDone,
    Refused,
    Running,
    SameObject,
    Settled,
    Touched,
)

FORMAT = "firstcontact-live"
#: Raised whenever a field changes its meaning or goes.
FORMAT_VERSION = 2


def text(tree: Mapping[str, Any]) -> str:
    """One line of JSON, without its end; in place of one that cannot be, one that says so."""
    try:
        return json.dumps(tree, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
    except (ValueError, TypeError) as error:  # a number that is none, and what JSON does not know
        return json.dumps(of_failure(str(tree.get("type")), str(error)), separators=(",", ":"))


def of_failure(what: str, reason: str) -> dict[str, Any]:
    """Something could not be told, or a sink is no more."""
    return {"type": "failed", "of": what, "reason": reason}


def of_descriptor(descriptor: Descriptor) -> dict[str, Any]:
    """What sends, and the columns of its samples."""
    layout = descriptor.layout
    return {
        "type": "descriptor",
        "format": FORMAT,
        "format_version": FORMAT_VERSION,
        "firmware": descriptor.firmware,
        "sensor": descriptor.sensor,
        "hand": descriptor.hand,
        "source": descriptor.source,
        "answers": None if descriptor.predictor is None else asdict(descriptor.predictor),
        "rate_hz": layout.rate,
        "channels": [
            {"name": name, "kind": c.sensor or c.kind, "finger": _finger(c.finger), "unit": c.unit}
            for name, c in zip(layout.column_names, layout.column_channels, strict=True)
        ],
    }


def of_event(event: Event) -> dict[str, Any]:
    """One event."""
    match event:
        case Armed():
            return {"type": "armed", "sample": event.sample, "epoch": event.epoch}
        case Touched():
            return {
                "type": "touched",
                **_contact(event.contact),
                "first": event.first,
                "epoch": event.epoch,
                "host_s": event.host,
            }
        case Estimated():
            return {"type": "estimated", **_estimate(event)}
        case Running():
            return {"type": "running", **_running(event)}
        case Settled():
            return {
                "type": "standing",
                **_contact(event.contact),
                "answer": None if event.answer is None else _running(event.answer),
                "withdrawn": event.withdrawn,
                "complete": event.complete,
                "epoch": event.epoch,
                "reason": event.reason,
            }
        case Refused():
            return {
                "type": "refused",
                **_contact(event.contact),
                "reason": event.reason,
                "epoch": event.epoch,
            }
        case PinchDone():
            return {
                "type": "pinch",
                "number": event.number,
                "armed": event.armed,
                "end": event.end,
                "epoch": event.epoch,
                "contacts": [_contact(c) for c in event.contacts],
                "strips": [{"finger": _finger(f), "sample": s} for f, s in event.strips],
                "estimates": [_estimate(e) for e in event.estimates],
                "refused": event.refused,
                "standing": None if event.standing is None else _running(event.standing),
                "answers": len(event.answers),
                "available": None if event.available is None else _of_model(event.available),
                "case": _case(event.case),
            }
        case HandAsked():
            return _hand(event)
        case FromHand():
            told = event.told
            kind = "hand_contact" if isinstance(told, DeviceContact) else "hand_estimate"
            return {"type": kind, **_told(told), "host_s": event.host}
        case HandPinch():
            return {
                "type": "hand_pinch",
                "number": event.number,
                "model": event.model,
                "contacts": [_told(c) for c in (event.first, event.second) if c is not None],
                "standing": None if event.standing is None else _told(event.standing),
                "answers": event.answers,
                "epoch": event.epoch,
                "check": None
                if event.check is None
                else {**asdict(event.check), "same": event.check.same},
            }
        case SameObject():
            return {
                "type": "same_object",
                "number": event.number,
                "value": event.value,
                "low": event.low,
                "high": event.high,
                "level": event.level,
                "pinches": event.pinches,
                "told": event.told,
                "epoch": event.epoch,
            }


def _told(told: DevicePrediction) -> dict[str, Any]:
    """A contact or an estimate of the device's own."""
    if isinstance(told, DeviceContact):
        return {
            "finger": _finger(told.finger),
            "sample": told.sample,
            "decided": told.decided,
            "first": told.first,
            "epoch": told.epoch,
        }
    return {
        "finger": _finger(told.finger),
        "sample": told.contact,
        "samples": told.samples,
        "complete": told.decided,
        "value": None if told.refused else told.value,
        "low": None if told.refused else told.low,
        "high": None if told.refused else told.high,
        "refused": told.refused,
        "out_of_range": told.out_of_range,
        "took_s": told.compute_time,
        "epoch": told.epoch,
    }


def _hand(event: HandAsked) -> dict[str, Any]:
    return {
        "type": "hand",
        "told": event.ask.value,
        "by": event.by,
        "sample": event.sample,
        "epoch": event.epoch,
    }


def of_marker(marker: Marker) -> dict[str, Any]:
    """A word that was pinned to a sample."""
    return {
        "type": "marker",
        "sample": marker.sample,
        "epoch": marker.epoch,
        "text": marker.text,
    }


def of_link(health: Health) -> dict[str, Any]:
    """How the link is doing: without the counts that always move."""
    return {
        "type": "link",
        "connected": health.connected,
        "epoch": health.epoch,
        "lost_samples": health.lost_samples,
        "overflow_samples": health.overflow_samples,
        "unusable_samples": health.unusable_samples,
        "lost_frames": health.lost_frames,
        "bad_frames": health.bad_frames,
        "doubled_frames": health.doubled_frames,
        "late_answers": health.late_answers,
        "unheard_samples": health.unheard_samples,
        "reconnects": health.reconnects,
    }


def _finger(finger: Finger | None) -> str | None:
    return None if finger is None else finger.name.lower()


def _contact(contact: Contact) -> dict[str, Any]:
    return {
        "finger": _finger(contact.finger),
        "sample": contact.sample,
        "decided": contact.decided,
    }


def _case(case: Case | None) -> str | None:
    return None if case is None else case.name.lower()


def _of_model(event: Running | Estimated) -> dict[str, Any]:
    return _running(event) if isinstance(event, Running) else _estimate(event)


def _running(event: Running) -> dict[str, Any]:
    return _answer(
        event,
        {
            "out_of_range": event.strange,
            "samples": event.samples,
            "signal_s": event.duration,
            "told_shape": in_words(event.radius) or None,
        },
    )


def _estimate(event: Estimated) -> dict[str, Any]:
    return _answer(
        event,
        {"window_s": event.duration},
        {"used": event.used},
    )


def _answer(
    event: Answer, signal: Mapping[str, Any], judged: Mapping[str, Any] | None = None
) -> dict[str, Any]:
    """What all answers tell, with what one says of its signal and of itself."""
    return {
        **_contact(event.contact),
        "value": event.value,
        "low": event.low,
        "high": event.high,
        "level": event.level,
        **signal,
        "complete": event.complete,
        "epoch": event.epoch,
        **(judged or {}),
        "host_s": event.host,
        "compute_s": event.compute,
        "waited_s": event.waited,
        "transport_s": event.transport,
    }
