"""Small model for the device, and the host's predictions to compare with the device's."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from firstcontact.contact import DETECTORS, detect, make_detector
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
    cut_touches,
    load_model,
    pretrained,
)
from firstcontact.streaming import ContactEvent, Estimate, Event, NetworkPredictor, Pipeline
from firstcontact.twin import BLOCKS, PAPER_RIG, draw_pinch, draw_specimen, simulate_pinch

#: Noise floors of the twin's fingertips, V.
FLOORS = Calibration(tuple(VibrationCalibration(f, 0.0018) for f in Finger))


def trained() -> tuple[Dataset, Trained]:
    """Return pinches of the five blocks, and the models trained on them."""
    pinches = []
    for n in range(45):
        kind = BLOCKS[n % len(BLOCKS)]
        specimen = draw_specimen(5, PAPER_RIG, kind, 0)
        draw = draw_pinch(5, PAPER_RIG, f"s{n % 4}", specimen, n)
        label = Label(kind.name, kind.shore_a, session=f"s{n % 4}", specimen=kind.name)
        pinches.append(simulate_pinch(draw, label, 10_000 * n))
    dataset = Dataset(tuple(pinches), "twin")
    detector = make_detector(DETECTORS.default).fit(dataset)
    contacts = [next(iter(detect(detector, p)), None) for p in dataset.pinches]
    touches, indices = cut_touches(dataset, contacts)
    network = pretrained().conditioned_on({ANY: Rig.fit(touches, dataset.shore_a[indices])})
    return dataset, Trained((), detector, compacted(network, touches, 8))


def models(folder: Path) -> None:
    """Write two different models for the device, ``first`` and ``second``."""
    _, first = trained()
    assert isinstance(first.anytime, CompactModel)
    wider = CompactModel(
        first.anytime.network,
        first.anytime.familiar,
        1.5 * first.anytime.factors,
        first.anytime.level,
        first.anytime.rigs,
    )
    paths = folder / "first", folder / "second"
    for path, anytime in zip(paths, (first.anytime, wider), strict=True):
        path.mkdir(parents=True)
        write(Trained((), first.detector, anytime), path)


def host_events(folder: Path, data: np.ndarray) -> list[Event]:
    """Return the events of the host's live pipeline for these samples, with the same model."""
    layout = fingertip_layout()
    model = load_model(folder)
    assert model.network is not None
    predictor = NetworkPredictor(model.network.model)
    pipeline = Pipeline(layout, model.own_detector, predictor, FLOORS, resettles=False)
    blocks = [Block(data[k : k + 5], k) for k in range(0, len(data), 5)]
    events = [event for block in blocks for event in pipeline.update(block, 0.0)]
    return events + pipeline.finish()


@dataclass(frozen=True)
class Predictions:
    """Contacts and estimates of a device or of the host.

    The key of an estimate is its contact and its number of samples. The value is the estimate, the
    ends of its interval, the out-of-range flag and the sample with which it was complete.
    """

    contacts: list[tuple[Finger | None, int, int, bool]]
    estimates: dict[tuple[int, int], tuple[float, float, float, bool, int]]


def of_host(events: list[Event]) -> Predictions:
    """Return the predictions among the host's events."""
    touched = [e for e in events if isinstance(e, ContactEvent)]
    rate = fingertip_layout().rate
    running = [e for e in events if isinstance(e, Estimate) and not e.final]
    return Predictions(
        [(e.contact.finger, e.contact.sample, e.contact.decided, e.first) for e in touched],
        {
            (e.contact.sample, round(e.elapsed * rate)): (
                e.value,
                e.low,
                e.high,
                e.out_of_range,
                e.complete,
            )
            for e in running
        },
    )


def of_device(messages: list[DevicePrediction]) -> Predictions:
    """Return the predictions among the device's messages."""
    contacts = [m for m in messages if isinstance(m, DeviceContact)]
    estimates = [m for m in messages if isinstance(m, DeviceEstimate)]
    assert not any(t.refused for t in estimates)
    return Predictions(
        [(t.finger, t.sample, t.decided, t.first) for t in contacts],
        {
            (t.contact, t.samples): (t.value, t.low, t.high, t.out_of_range, t.decided)
            for t in estimates
        },
    )


def assert_same(device: Predictions, host: Predictions) -> None:
    """Assert that contacts are equal, and that estimates differ by at most 0.01 Shore A.

    If several estimates were due before the contact was detected, the device sends only the last.
    """
    assert device.contacts == host.contacts
    assert device.estimates.keys() <= host.estimates.keys()
    unsent = {key for key, e in host.estimates.items() if key not in device.estimates}
    for contact, samples in unsent:
        complete = host.estimates[contact, samples][4]
        assert any(c == contact and e[4] == complete for (c, _), e in device.estimates.items())
    for key, (*numbers, strange, sample) in device.estimates.items():
        *expected, odd, complete = host.estimates[key]
        np.testing.assert_allclose(numbers, expected, atol=0.01)
        assert (strange, sample) == (odd, complete)
