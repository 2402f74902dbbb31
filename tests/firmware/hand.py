"""A small model for the hand, the twin's hand as scans, and the host's own answers about them."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from firstcontact.contact import DETECTORS, detect, load_detector, make_detector
from firstcontact.core import (
    Block,
    Calibration,
    Dataset,
    Finger,
    Label,
    VibrationCalibration,
    fingertip_layout,
)
from firstcontact.device import DeviceContact, DeviceEstimate, DevicePrediction
from firstcontact.export import Trained
from firstcontact.export._hand_model import write
from firstcontact.models import (
    ANY,
    CompactModel,
    Rig,
    compacted,
    load_anytime,
    pretrained,
    touches_of,
)
from firstcontact.streaming import Pipeline, Running, Touched
from firstcontact.streaming._events import Event
from firstcontact.twin import BLOCKS, PAPER_RIG, draw_pinch, draw_specimen, simulate_pinch

#: Noise of the twin's fingertips at rest, V.
FLOORS = Calibration(tuple(VibrationCalibration(f, 0.0018) for f in Finger))


def trained() -> tuple[Dataset, Trained]:
    """Pinches of the five blocks, and what was learned from them."""
    pinches = []
    for n in range(45):
        kind = BLOCKS[n % len(BLOCKS)]
        specimen = draw_specimen(5, PAPER_RIG, kind, 0)
        draw = draw_pinch(5, PAPER_RIG, f"s{n % 4}", specimen, n)
        label = Label(kind.name, kind.shore_a, session=f"s{n % 4}", specimen=kind.name)
        pinches.append(simulate_pinch(draw, label, 10_000 * n))
    dataset = Dataset(tuple(pinches), "twin")
    detector = make_detector(DETECTORS.default).fit(dataset)
    found = [next(iter(detect(detector, p)), None) for p in dataset.pinches]
    touches, which = touches_of(dataset, found)
    told = pretrained().told_of({ANY: Rig.of(touches, dataset.shore_a[which])})
    return dataset, Trained((), detector, compacted(told, touches, 8))


def models(folder: Path) -> tuple[Path, Path]:
    """Two folders for a hand, with models that differ."""
    _, first = trained()
    assert isinstance(first.anytime, CompactModel)
    wider = CompactModel(
        first.anytime.network,
        first.anytime.familiar,
        1.5 * first.anytime.factors,
        first.anytime.level,
        first.anytime.rigs,
    )
    made = folder / "first", folder / "second"
    for path, anytime in zip(made, (first.anytime, wider), strict=True):
        path.mkdir()
        write(Trained((), first.detector, anytime), path)
    return made


def python_says(folder: Path, data: np.ndarray) -> list[Event]:
    """What live finds in samples with the same model."""
    layout = fingertip_layout()
    anytime = load_anytime(folder)
    pipeline = Pipeline(layout, load_detector(folder), (), FLOORS, anytime=anytime)
    blocks = [Block(data[k : k + 5], k) for k in range(0, len(data), 5)]
    events = [event for block in blocks for event in pipeline.update(block, 0.0)]
    return events + pipeline.finish()


@dataclass(frozen=True)
class Said:
    """Contacts, and estimates by contact and samples after it: value, ends, flag, known."""

    contacts: list[tuple[Finger | None, int, int, bool]]
    estimates: dict[tuple[int, int], tuple[float, float, float, bool, int]]


def of_host(events: list[Event]) -> Said:
    """The host's."""
    touched = [e for e in events if isinstance(e, Touched)]
    running = [e for e in events if isinstance(e, Running)]
    return Said(
        [(e.contact.finger, e.contact.sample, e.contact.decided, e.first) for e in touched],
        {
            (e.contact.sample, e.samples): (e.value, e.low, e.high, e.strange, e.complete)
            for e in running
        },
    )


def of_device(told: list[DevicePrediction]) -> Said:
    """The device's."""
    contacts = [t for t in told if isinstance(t, DeviceContact)]
    estimates = [t for t in told if isinstance(t, DeviceEstimate)]
    assert not any(t.refused for t in estimates)
    return Said(
        [(t.finger, t.sample, t.decided, t.first) for t in contacts],
        {
            (t.contact, t.samples): (t.value, t.low, t.high, t.out_of_range, t.decided)
            for t in estimates
        },
    )


def assert_same(device: Said, host: Said) -> None:
    """The same contacts; the same answer to 0.01 Shore A about each moment that the device told.

    Of the milliseconds that were over when the contact became known it tells the last only.
    """
    assert device.contacts == host.contacts
    assert device.estimates.keys() <= host.estimates.keys()
    at_once = {key for key, e in host.estimates.items() if key not in device.estimates}
    for contact, samples in at_once:
        known = host.estimates[contact, samples][4]
        assert any(c == contact and e[4] == known for (c, _), e in device.estimates.items())
    for key, (*numbers, strange, known) in device.estimates.items():
        *wanted, odd, complete = host.estimates[key]
        np.testing.assert_allclose(numbers, wanted, atol=0.01)
        assert (strange, known) == (odd, complete)
