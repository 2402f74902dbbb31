"""Live session on a recording: no losses, offline results, and clean-up at every exit."""

import threading
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from streams import Keeper

from firstcontact.contact import Detector
from firstcontact.core import (
    Block,
    Calibration,
    Finger,
    InputError,
    Physical,
    VibrationCalibration,
    fingertip_layout,
)
from firstcontact.device.replay import ReplaySource
from firstcontact.grasp.printing import PrintHand
from firstcontact.grasp.registry import live_policy
from firstcontact.models import WindowPredictor
from firstcontact.models.anytime import PredictorLadder
from firstcontact.models.rig.rig_model import RigModel
from firstcontact.recording import Header, Marker, RecordingWriter, load_dataset, read_recording
from firstcontact.streaming import Event, Pipeline, Update
from firstcontact.streaming.grasping import Grasping
from firstcontact.streaming.session import LiveSession
from firstcontact.twin import TwinStream
from firstcontact.twin.sensor import DeviceFilter

LAYOUT = fingertip_layout()
SECONDS = 12


class TooFast(PrintHand):
    """Hand that reports positions faster than any sensor of the fingertips."""

    position_rate = 1e4


class Actor:
    """Stand-in for a hand's policy that does nothing."""

    hand = PrintHand()
    is_used = None

    def on_event(self, event: Event) -> None:
        """Ignore the call."""

    def on_samples(self, block: Block, host: float) -> None:
        """Ignore the call."""

    def take_commands(self) -> Sequence[Event]:
        return ()

    def after_block(self, block: Block) -> Sequence[Event]:
        return ()


@pytest.fixture(scope="module")
def stream() -> np.ndarray:
    """Return the samples of a twin hand that picks up objects for ``SECONDS``."""
    twin = TwinStream("paper-rig", None, 3)
    return DeviceFilter().update(twin.read(round(SECONDS * LAYOUT.rate)))


@pytest.fixture(scope="module")
def calibration(stream: np.ndarray) -> Calibration:
    quiet = Physical(LAYOUT, (0, 1))(stream[: round(0.5 * LAYOUT.rate)])
    return Calibration(
        tuple(VibrationCalibration(f, float(quiet[:, i].std())) for i, f in enumerate(Finger))
    )


@pytest.fixture
def recorded(stream: np.ndarray, calibration: Calibration, tmp_path: Path) -> Path:
    path = tmp_path / "stream.mcap"
    with RecordingWriter(path, Header(LAYOUT, "twin", calibration=calibration)) as writer:
        writer.marker(Marker(12_345, "orange"))
        writer.write(Block(stream, 12_345))
    return path


def run(
    path: Path, detector: Detector, models: list[WindowPredictor], **more: object
) -> tuple[LiveSession, Keeper]:
    source = ReplaySource(path, float("inf"))
    keeper = Keeper()
    with source:
        pipeline = Pipeline(
            LAYOUT, detector, PredictorLadder(models) if models else None, source.calibration
        )
        session = LiveSession(source, pipeline, **more)  # type: ignore[arg-type]
        session.run([keeper])
    return session, keeper


def test_every_sample_reaches_the_sinks_once_and_in_order(
    recorded: Path, stream: np.ndarray, detector: Detector
) -> None:
    _, keeper = run(recorded, detector, [])
    assert keeper.closed.is_set()
    blocks = [a.block for u in keeper.updates for a in u.arrivals]
    numbers = np.concatenate([b.first_sample + np.arange(len(b.data)) for b in blocks])
    assert np.array_equal(numbers, 12_345 + np.arange(len(stream)))
    assert np.array_equal(np.concatenate([b.data for b in blocks]), stream)


def test_a_recording_of_a_session_is_a_dataset_that_replays_the_same(
    recorded: Path,
    stream: np.ndarray,
    calibration: Calibration,
    detector: Detector,
    models: list[WindowPredictor],
    tmp_path: Path,
) -> None:
    source = ReplaySource(recorded, float("inf"))
    keeper = Keeper()
    with source:
        pipeline = Pipeline(
            LAYOUT, detector, PredictorLadder(models) if models else None, source.calibration
        )
        session = LiveSession(
            source, pipeline, recordings=tmp_path / "made", calibration=calibration
        )
        path = session.start_recording()
        session.run([keeper])
    again = read_recording(path)
    assert again.samples == len(stream)
    assert again.skipped == ()
    assert again.header.calibration == calibration
    assert [(m.first_sample, m.end) for m in again.pinches] == [
        (d.start, d.end) for d in keeper.pinches
    ]
    pinches = load_dataset(path).pinches
    assert {p.label.object for p in pinches} == {"orange"}
    assert [[c.sample for c in p.truth] for p in pinches] == [
        [c.sample for c in d.strips] for d in keeper.pinches
    ]
    _, repeated = run(path, detector, models)
    assert [[e.value for e in d.estimates] for d in repeated.pinches] == [
        [e.value for e in d.estimates] for d in keeper.pinches
    ]


def test_an_actor_that_raises_ends_the_session_and_closes_everything(
    recorded: Path, detector: Detector, tmp_path: Path
) -> None:
    order: list[str] = []

    class Failing(Actor):
        def on_event(self, event: Event) -> None:
            raise RuntimeError(f"an actor's fault at {type(event).__name__}")

        def ended(self) -> None:
            order.append("actor ended")

    source = ReplaySource(recorded, float("inf"))
    keeper = Keeper()
    with source:
        session = LiveSession(source, Pipeline(LAYOUT, detector), Failing(), recordings=tmp_path)
        path = session.start_recording()
        with pytest.raises(RuntimeError, match="at ClosingStart"):
            session.run([keeper])
    assert order == ["actor ended"]
    assert keeper.closed.is_set()
    assert session.recording.path is None
    recording = read_recording(path)
    assert recording.skipped == ()
    # The samples that the fault was found in are there, too.
    assert recording.samples == source.health.samples > 0


@pytest.mark.parametrize("when", ["ended", "close"])
def test_a_recording_that_begins_while_the_session_ends_is_refused_or_closed(
    when: str, recorded: Path, detector: Detector, tmp_path: Path
) -> None:
    class Viewer(Keeper, Actor):
        refused = False

        def ended(self) -> None:
            self.record("ended")

        def close(self) -> None:
            self.record("close")
            super().close()

        def record(self, now: str) -> None:
            try:
                if now == when:
                    session.start_recording()
            except InputError:
                self.refused = True

    viewer = Viewer()
    with ReplaySource(recorded, float("inf")) as source:
        session = LiveSession(source, Pipeline(LAYOUT, detector), viewer, recordings=tmp_path)
        session.run([viewer])
    assert viewer.closed.is_set()
    assert session.recording.path is None
    paths = list(tmp_path.glob("live-*.mcap"))
    assert viewer.refused == (when == "close") == (not paths)
    assert all(read_recording(path).skipped == () for path in paths)


def test_it_ends_after_a_number_of_pinches_or_on_request(
    recorded: Path, stream: np.ndarray, detector: Detector
) -> None:
    for bound in ({"pinches": 2}, {"seconds": 0.0}, {"stopped": lambda: True}):
        source = ReplaySource(recorded, float("inf"))
        with source:
            session = LiveSession(source, Pipeline(LAYOUT, detector, None, source.calibration))
            session.run([], **bound)  # type: ignore[arg-type]
            assert source.health.samples < len(stream)
            assert session.pinches == bound.get("pinches", 0)


@pytest.mark.parametrize("limit", ["stopped", "seconds"])
def test_it_ends_although_a_reader_stalls(limit: str, recorded: Path, detector: Detector) -> None:
    go_on = threading.Event()
    stalled = Keeper(go_on=go_on)
    with ReplaySource(recorded, float("inf")) as source:
        session = LiveSession(source, Pipeline(LAYOUT, detector, None, source.calibration))
        bound = {"stopped": stalled.taking.is_set, "seconds": 0.2}[limit]
        session.run([stalled], **{limit: bound}, patient=True)  # type: ignore[arg-type]
    go_on.set()


def test_it_ends_when_nobody_is_left_to_tell(
    recorded: Path, stream: np.ndarray, detector: Detector
) -> None:
    class Leaver(Keeper):
        def take(self, update: Update) -> None:
            raise BrokenPipeError

    source = ReplaySource(recorded, 1.0)  # or all may be read before anybody has left
    with source:
        session = LiveSession(source, Pipeline(LAYOUT, detector))
        session.run([Leaver()], patient=True)
        assert source.health.samples < len(stream)


def test_a_failed_output_is_told_to_the_others_once(recorded: Path, detector: Detector) -> None:
    class Raiser(Keeper):
        def take(self, update: Update) -> None:
            raise RuntimeError("no")

    keeper = Keeper()

    def stopped() -> bool:
        failures = [bool(update.failed) for update in keeper.updates]
        return True in failures[:-3]

    with ReplaySource(recorded, 1.0) as source:
        session = LiveSession(source, Pipeline(LAYOUT, detector))
        session.run([Raiser("raiser"), keeper], stopped=stopped)
    assert [u.failed for u in keeper.updates if u.failed] == [{"raiser": "RuntimeError: no"}]


def test_a_shape_that_a_viewer_tells_holds_for_one_object(
    recorded: Path, detector: Detector, anytime: RigModel
) -> None:
    with ReplaySource(recorded, float("inf")) as source:
        pipeline = Pipeline(LAYOUT, detector, anytime)
        session = LiveSession(source, pipeline, shape="flat")
        assert pipeline.translator.radius == np.inf
        assert session.set_shape("40") == "radius 40 mm"
        assert pipeline.translator.radius == pytest.approx(0.04)
        session.new_object()
        assert pipeline.translator.radius == np.inf
        with pytest.raises(InputError, match="egg"):
            session.set_shape("egg")
        assert pipeline.translator.radius == np.inf
        with pytest.raises(InputError):
            LiveSession(source, Pipeline(LAYOUT, detector), shape="flat")


def test_positions_faster_than_the_samples_are_refused(
    recorded: Path, detector: Detector, tmp_path: Path
) -> None:
    with ReplaySource(recorded, float("inf")) as source:
        pipeline = Pipeline(LAYOUT, detector)
        grasping = Grasping(live_policy("touch"), TooFast(), LAYOUT)
        session = LiveSession(source, pipeline, grasping, recordings=tmp_path)
        with pytest.raises(InputError) as refused:
            session.start_recording()
    assert refused.value.parameter == "hand"
