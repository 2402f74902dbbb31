"""Public functions: a program that uses all of them, and refusals."""

import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import firstcontact as fc
from firstcontact import plugins
from firstcontact.core.calibration import write_calibration
from firstcontact.grasp import Hand, HandLimits, SafeHand

pytestmark = pytest.mark.usefixtures("small_searches")
EXAMPLES = Path(__file__).parents[1] / "examples"


@pytest.fixture(scope="module")
def data(tmp_path_factory):
    """Simulated pinches of the five blocks."""
    folder = tmp_path_factory.mktemp("front") / "pinches"
    return fc.simulate(folder, pinches_per_block=12, pinches_per_object=0, seed=5)


@pytest.fixture(scope="module")
def training(data):
    """Model and the progress of its training."""
    steps: list[int] = []
    name = "spectral_ridge" if "spectral_ridge" in plugins.ESTIMATORS else "svm"
    return fc.train(data, name, progress=steps.append), steps


@pytest.fixture(scope="module")
def model(training):
    return training[0]


def test_every_public_name_exists():
    for name in fc.__all__:
        assert getattr(fc, name) is not None
    assert {"load", "train", "live", "plugins", "InputError"} <= set(fc.__all__)


def test_importing_it_imports_no_arrays():
    code = "import sys, firstcontact; print(*sys.modules)"
    modules = subprocess.check_output([sys.executable, "-c", code], text=True).split()
    assert not set(modules) & {"numpy", "scipy", "sklearn", "torch", "msgspec"}


def test_progress_counts_every_step(data, training):
    model, progress = training
    assert sum(progress) == 3 + len(model.windows)
    steps: list[int] = []
    fc.adapt(data, progress=steps.append)
    assert sum(steps) == 3
    steps.clear()
    fc.evaluate(model, data, progress=steps.append)
    assert sum(steps) == 2  # the network and the window model


def test_training_warns_of_pinches_with_the_same_samples(data, training):
    copied = [replace(p, label=replace(p.label, session="copied")) for p in data[:3]]
    noted = fc.adapt(replace(data, pinches=(*data.pinches, *copied))).notes
    assert [note for note in noted if note.startswith("warning: 3 pinches ")] == [noted[-1]]
    assert not any(note.startswith("warning") for note in training[0].notes)


def test_a_model_predicts_the_same_after_saving(data, model, tmp_path):
    again = fc.load_model(model.save(tmp_path / "rig"))
    assert again.prediction_times == model.prediction_times
    assert again.estimators == model.estimators
    for estimator, at in (("combined", 0.003), (None, 0.015)):
        predictions, selected = (
            m.predict(data, at=at, estimator=estimator) for m in (model, again)
        )
        assert np.array_equal(predictions.value, selected.value, equal_nan=True)
        assert np.array_equal(predictions.low, selected.low, equal_nan=True)


def test_the_predictor_is_chosen_by_its_name(data, model):
    """The estimator that was asked for predicts by default, and the predictions name it."""
    window = model.predict(data)
    assert window.elapsed[np.isfinite(window.elapsed)] == pytest.approx(0.015, abs=1e-4)
    early = model.predict(data, at=0.005, estimator="combined")
    assert (window.estimator, early.estimator) == model.estimators == ("svm", "combined")
    assert any(note.startswith("the estimator svm predicts") for note in model.notes)
    with pytest.raises(fc.InputError) as caught:
        model.predict(data, estimator="nobody")
    assert caught.value.parameter == "estimator"


def test_each_wrong_value_is_refused_where_it_enters(data, model, tmp_path):
    nul, out = "a\0b", tmp_path / "out"
    bare = replace(data, pinches=tuple(replace(p, truth=()) for p in data[:10]))
    with fc.open("twin", speed=4.0) as source:
        calls = [
            ("data", lambda: fc.train("pinches")),
            ("data", lambda: model.predict(data.pinches[0])),
            ("data", lambda: fc.evaluate(model, "pinches")),
            ("data", lambda: fc.detect(list(data))),
            ("data", lambda: fc.train(data[:0])),
            ("data", lambda: model.predict(data[:0])),
            ("data", lambda: fc.evaluate(model, data[:0])),
            ("data", lambda: fc.detect(data[:0])),
            ("contacts", lambda: model.predict(data, contacts=[])),
            ("contacts", lambda: fc.evaluate(model, data, contacts="truth")),
            ("contacts", lambda: fc.train(bare, contacts="known")),
            ("level", lambda: fc.train(data[:10], level=0.2)),
            ("seed", lambda: fc.train(data[:10], seed=-1)),
            ("windows", lambda: fc.train(data[:10], windows=(5.0,))),
            ("windows", lambda: fc.train(data[:10], windows=())),
            ("source", lambda: next(fc.live("twin"))),
            ("detector", lambda: fc.detect(data, 3)),
            ("source", lambda: fc.calibrate("x")),
            ("source", lambda: fc.record("x", out)),
            ("session", lambda: fc.record(source, out, session=b"3")),
            ("", lambda: source.mark(3)),
            ("hand", lambda: next(fc.live(source, hand=3))),
            ("shore_a", lambda: fc.Label(shore_a=float("nan"))),
            ("speed", lambda: fc.open("twin", speed=1e308).__enter__()),
            ("path", lambda: fc.load(nul)),
            ("path", lambda: fc.import_recordings(nul, out)),
            ("out", lambda: fc.import_recordings(tmp_path, nul)),
            ("out", lambda: fc.simulate(nul)),
            ("out", lambda: fc.record(source, nul, object="block 29")),
            ("out", lambda: fc.export_model(model, nul, to="c")),
            ("at", lambda: model.predict(data, at=0.0005)),
            ("detector", lambda: fc.evaluate(model, data, detector="svm")),
            ("device", lambda: fc.open(nul)),
            ("model", lambda: fc.load_model(nul)),
            ("folder", lambda: model.save(nul)),
            ("calibration", lambda: next(fc.live(source, calibration=nul))),
            ("record", lambda: next(fc.live(source, record=nul))),
        ]
        for parameter, call in calls:
            with pytest.raises(fc.InputError) as caught:
                call()
            assert caught.value.parameter == parameter
    assert list(tmp_path.iterdir()) == []


def test_a_hand_of_ones_own_is_driven_and_released():
    class MyHand(Hand):
        name = "mine"
        limits = HandLimits(speed=0.5, force=20.0, rate=200.0, watchdog=float("inf"))
        real = False

        def __init__(self):
            self.calls: list[str] = []

        def send(self, command):
            self.calls.append("send")

        def release(self):
            self.calls.append("release")

        def close(self):
            self.release()

    for wrap in (lambda hand: hand, SafeHand):
        hand = MyHand()
        with fc.open("twin", speed=4.0) as source:
            list(fc.live(source, hand=wrap(hand), pinches=1))
        assert hand.calls[-1] == "release"


def test_evaluation_scores_each_predictor_apart(data, model):
    window, network = fc.evaluate(model, data)
    assert network.groups[0].title == "seen in training"
    assert set(network.groups[0].rmse) == {0.002, 0.003, 0.005, 0.008, 0.015}
    assert set(window.groups[0].rmse) == {0.015}
    assert not network.rmse  # no score on training data
    assert not window.rmse
    assert window.scored + window.left_out == len(data)


def test_a_model_is_written_as_c(data, model, tmp_path):
    assert fc.export_model(model, tmp_path / "c", to="c", data=data)
    assert list((tmp_path / "c").rglob("*.c"))
    with pytest.raises(fc.InputError) as refused:
        fc.export_model(model, tmp_path / "c", to="c")
    assert refused.value.parameter == "out"


def test_contacts_are_detected(data):
    pairs = zip(fc.detect(data), data, strict=True)
    late = [(d.sample - p.first.sample) / data.layout.rate for d, p in pairs if d is not None]
    assert np.median(np.abs(late)) < 0.003


def test_live_gives_a_final_estimate_for_each_pinch():
    with fc.open("twin", speed=8.0, seed=2) as source:
        calibration = fc.calibrate(source, seconds=0.5)
        events = list(fc.live(source, calibration=calibration, pinches=2))
    assert not any(e.real_time for e in events if isinstance(e, fc.PinchDone))
    finished_pinch = [e for e in events if isinstance(e, fc.PinchDone)]
    assert len(finished_pinch) == 2
    assert sum(isinstance(e, fc.Estimate) and e.final for e in events) >= 2


def test_leaving_live_early_closes_the_source():
    with fc.open("twin", speed=8.0, seed=3) as source:
        calibration = fc.calibrate(source, seconds=0.5)
        events = fc.live(source, calibration=calibration)
        next(events)
        events.close()
        assert source.ended or not source.health.connected


def test_recorded_pinches_are_loaded_again(tmp_path):
    counted: list[int] = []
    with fc.open("twin", speed=8.0, seed=4) as source:
        label = {"object": "block 29", "shore_a": 29.0}
        path = fc.record(source, tmp_path / "own", **label, pinches=2, progress=counted.append)
    again = fc.load(path)
    assert sum(counted) == len(again) == 2
    assert set(again.shore_a) == {29.0}


class Node:
    """Stand-in for ``rclpy.node.Node`` with its interface but without ROS."""

    def __init__(self, name):
        self.published = []

    def create_publisher(self, kind, topic, depth):
        assert (topic, depth) == ("stiffness", 10)
        return SimpleNamespace(publish=self.published.append)


def test_the_ros_node_publishes_each_estimate(monkeypatch):
    rclpy = SimpleNamespace(ok=lambda: True)
    messages = SimpleNamespace(Float32MultiArray=SimpleNamespace)
    for name, module in {
        "rclpy": rclpy,
        "rclpy.node": SimpleNamespace(Node=Node),
        "std_msgs": SimpleNamespace(),
        "std_msgs.msg": messages,
    }.items():
        monkeypatch.setitem(sys.modules, name, module)
    monkeypatch.syspath_prepend(str(EXAMPLES))
    monkeypatch.delitem(sys.modules, "ros_node", raising=False)
    import ros_node

    node = ros_node.Stiffness("twin", None, pinches=1)
    node.run()
    assert node.published
    for message in node.published:
        value, low, high = message.data
        assert low <= value <= high


@pytest.mark.parametrize(
    ("options", "parameter"),
    [
        ({"hand": "ability"}, "hand"),  # it closes only when it is asked to
        ({"hand": "nobody"}, ""),
        ({"policy": "stiffness"}, "policy"),
        ({"hand_port": "/dev/null"}, "hand_port"),
        ({"seconds": -1.0}, "seconds"),
        ({"pinches": 0}, "pinches"),
    ],
)
def test_live_refuses_before_it_touches_the_source(options, parameter):
    with pytest.raises(fc.InputError) as caught:
        next(fc.live(fc.open("twin"), **options))
    assert caught.value.parameter == parameter


@pytest.mark.parametrize("shape", [np.float32(30), "30 mm"])
def test_live_takes_a_shape_as_a_number_in_mm(shape, tmp_path):
    with fc.open("twin", speed=8.0, seed=2) as source:
        path = tmp_path / "calibration.json"
        write_calibration(fc.calibrate(source, seconds=0.5), path)
        events = list(fc.live(source, calibration=path, shape=shape, pinches=1))
    assert {e.shape for e in events if isinstance(e, fc.Estimate)} == {"radius 30 mm"}
