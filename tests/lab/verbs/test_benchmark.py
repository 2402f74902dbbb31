"""Benchmark of a user's regressor on simulated rigs and on recordings."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from firstcontact.core import Dataset, Label, Role
from firstcontact.models import ESTIMATORS
from firstcontact.recording import Header, write_dataset
from firstcontact_lab.report.results import SubjectResults
from firstcontact_lab.study import benchmark
from firstcontact_lab.study._rig_sets import Sizes
from firstcontact_lab.study.benchmark import BENCHMARK, RECORDINGS, RecordedData
from firstcontact_lab.study.page import read_study
from firstcontact_lab.study.parts.generalise import GENERALISE
from trainings import LAYOUT, recordings, run, touch

#: `tests/lab/study/test_off_blocks.py` renders such a figure.
pytestmark = pytest.mark.usefixtures("unpainted")

MINE = """
import numpy as np
from sklearn.linear_model import Ridge
from sklearn.pipeline import make_pipeline
from sklearn.preprocessing import StandardScaler

class Loud:
    def fit(self, X, y):
        self.line = np.polyfit(np.log(X.std(axis=1)), y, 1)

    def predict(self, X):
        return np.polyval(self.line, np.log(X.std(axis=1)))

class Broken(Loud):
    def predict(self, X):
        return np.full(len(X), np.nan)

class Half:
    def fit(self, X, y): ...

class Picky(Loud):
    def fit(self, X, y):
        raise RuntimeError("no data\\nis good enough")

class Sealed(Loud):
    # Refuses windows that it has learned from.
    def fit(self, X, y):
        super().fit(X, y)
        self.learned = {row.tobytes() for row in X}

    def predict(self, X):
        if any(row.tobytes() in self.learned for row in X):
            raise RuntimeError("these windows are not held out")
        return super().predict(X)

pipeline = make_pipeline(StandardScaler(), Ridge())
"""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "their_regressors.py").write_text(MINE, encoding="utf-8")
    (tmp_path / "their_slip.py").write_text("def fit(:\n", encoding="utf-8")
    sizes = Sizes(blocks=6, held_out=3, objects=5, other_blocks=3, kinds=6)
    monkeypatch.setattr(benchmark, "QUICK", replace(benchmark.QUICK, sizes=sizes))
    monkeypatch.chdir(tmp_path)
    monkeypatch.delitem(__import__("sys").modules, "their_regressors", raising=False)
    return tmp_path


def run_benchmark(name: str, *more: str) -> int:
    words = ("--quick", "--condition", "paper-rig", "--workers", "1", "--out", "b")
    return run("benchmark", name, *words, *more)


def written(folder: Path) -> SubjectResults:
    return read_study(folder / "b" / "results.json").about


def written_scores(folder: Path) -> RecordedData:
    results = written(folder)[RECORDINGS]
    assert results is not None
    return results


def test_a_pipeline_lands_in_the_table_beside_ours(folder: Path, capsys: Any) -> None:
    name = "their_regressors:pipeline"
    assert run_benchmark(name) == 0
    output = capsys.readouterr().out
    assert name in output
    assert "In-context network" in output
    results = written(folder)
    generalised, by_time = results[GENERALISE], results[BENCHMARK]
    assert generalised is not None
    assert by_time is not None
    assert next(iter(generalised.estimators)) == name
    times = by_time[name]
    for scores in (times.rmse, times.coverage, times.width):
        assert list(scores) == ["2", "3", "5", "8", "15"]
    page = (folder / "b" / "report.html").read_text(encoding="utf-8")
    assert name in page
    assert page.count("data:image/svg") == 1


@pytest.mark.parametrize(
    ("name", "why"),
    [
        ("their_regressors:Nobody", "cannot be imported"),
        ("not_there_at_all:Loud", "cannot be imported"),
        (":Loud", "cannot be imported"),
        ("their_slip:Loud", "SyntaxError"),
        ("their_regressors:Picky", "Picky.fit raised RuntimeError: no data is good enough"),
        ("their_regressors:Half", "is no regressor"),
        ("their_regressors:Broken", "not a finite number"),
        ("their_regressors", "their_regressors"),
    ],
)
def test_who_cannot_be_asked_is_refused(folder: Path, capsys: Any, name: str, why: str) -> None:
    assert run_benchmark(name) == 2
    errors = capsys.readouterr().err
    assert why in errors.splitlines()[-1]
    assert not (folder / "b").exists()


LOUD = "their_regressors:Loud"


@pytest.fixture
def quick_default(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(ESTIMATORS, "default", "peak")


def scored(folder: Path, name: str = LOUD, *more: str) -> int:
    return run("benchmark", name, "--recordings", folder, "--workers", "1", "--out", "b", *more)


def recorded(folder: Path, labels: list[Label], has_contacts: bool = True) -> Path:
    rng = np.random.default_rng(1)
    pinches = tuple(touch(label.shore_a or 20.0, label, rng, has_contacts) for label in labels)
    folder.mkdir()
    write_dataset(Dataset(pinches, "synthetic"), folder, Header(LAYOUT, "synthetic"))
    return folder


def block(shore: float | None, session: str, specimen: str = "") -> Label:
    return Label("block", shore, None, specimen, session)


@pytest.mark.usefixtures("quick_default")
def test_recordings_are_scored_on_the_same_held_out_sessions(folder: Path, capsys: Any) -> None:
    data = recordings(folder / "pinches", ("a", "b", "c", "d", "e"))
    assert scored(data, "their_regressors:Sealed") == 0
    text = capsys.readouterr().out
    computed = written_scores(folder)
    assert (computed.path, computed.source, computed.pinches) == (str(data), "synthetic", 79)
    assert (computed.held_out.cluster, computed.held_out.clusters, computed.held_out.folds) == (
        "session", 5, 5,
    )  # fmt: skip
    for group, pinches in ((computed.held_out, 75), (computed.objects, 4)):
        assert list(group.scores) == ["their_regressors:Sealed", "peak", "combined", "in_context"]
        for scores in group.scores.values():
            assert scores.n == pinches
            assert list(scores.rmse) == ["2", "3", "5", "8", "15"]
    assert all(entry.intervals["rmse"] for entry in computed.held_out.scores.values())
    assert computed.objects.clusters == 1
    assert not any(entry.intervals for entry in computed.objects.scores.values())
    page = (folder / "b" / "report.html").read_text(encoding="utf-8")
    for displayed in (text, page):
        assert "synthetic recordings" in displayed
        assert str(data) in displayed
        assert "bootstrap interval over 5 sessions" in displayed
        assert "In-context network" in displayed
        assert "Twin" not in displayed


@pytest.mark.usefixtures("quick_default")
@pytest.mark.parametrize(
    ("labels", "why"),
    [
        ([block(s, "a") for s in (10.0, 60.0)], "sessions"),
        ([block(s, "") for s in (10.0, 60.0)], "sessions"),
        ([block(None, s) for s in "ab"], "Shore A"),
        ([block(20.0, s) for s in "ab"], "two Shore A levels"),
        ([block(10.0, "a"), block(60.0, "b")], "two Shore A levels"),
        ([Label("apple", s, None, "x", "a", Role.TEST) for s in (1.0, 9.0)], '"test"'),
    ],
)
def test_recordings_without_labels_or_sessions_are_refused(
    folder: Path, capsys: Any, labels: list[Label], why: str
) -> None:
    data = recorded(folder / "pinches", labels * 6)
    assert scored(data) == 2
    message = capsys.readouterr().err
    assert str(data) in message.splitlines()[-1]
    assert why in message
    assert not (folder / "b").exists()


def test_settings_of_the_twin_are_refused_with_recordings(folder: Path, capsys: Any) -> None:
    assert scored(folder, LOUD, "--quick") == 2
    assert scored(folder, LOUD, "--condition", "paper-rig") == 2
    assert "--recordings" in capsys.readouterr().err
    assert scored(folder / "absent") == 2
    assert not (folder / "b").exists()
