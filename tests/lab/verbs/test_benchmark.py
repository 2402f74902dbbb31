"""Anybody's regressor is asked what ours are asked."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from trainings import run

from firstcontact_lab.report.results.benchmark import BenchmarkResults
from firstcontact_lab.report.results.file import read_results

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

class Leaving(Loud):
    def fit(self, X, y):
        raise SystemExit(0)

class OddError(BaseException): ...

class Odd(Loud):
    def predict(self, X):
        raise OddError

pipeline = make_pipeline(StandardScaler(), Ridge())
number = 5
"""


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "their_regressors.py").write_text(MINE, encoding="utf-8")
    (tmp_path / "their_slip.py").write_text("def fit(:\n", encoding="utf-8")
    (tmp_path / "their_driver.py").write_text("raise RuntimeError('no board')\n", encoding="utf-8")
    (tmp_path / "their_exit.py").write_text("raise SystemExit(0)\n", encoding="utf-8")
    (tmp_path / "their_break.py").write_text("raise KeyboardInterrupt\n", encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    monkeypatch.delitem(__import__("sys").modules, "their_regressors", raising=False)
    return tmp_path


def asked(name: str, *more: str) -> int:
    words = ("--quick", "--condition", "paper-rig", "--workers", "1", "--out", "b")
    return run("benchmark", name, *words, *more)


def test_a_pipeline_lands_in_the_table_beside_ours(here: Path, capsys: Any) -> None:
    name = "their_regressors:pipeline"
    assert asked(name) == 0
    said = capsys.readouterr().out
    assert name in said
    assert "In-context network" in said
    found = read_results(here / "b" / "results.json", BenchmarkResults)
    both = found.conditions["paper-rig"]
    assert next(iter(both.generalise.estimators)) == found.contender == name
    times = both.anytime[name]
    for scores in (times.rmse, times.coverage, times.width):
        assert list(scores) == ["2", "3", "5", "8", "15"]
    page = (here / "b" / "report.html").read_text(encoding="utf-8")
    assert name in page
    assert page.count("data:image/svg") == 2


@pytest.mark.parametrize(
    ("name", "why"),
    [
        ("their_regressors:Nobody", "cannot be imported"),
        ("not_there_at_all:Loud", "cannot be imported"),
        (":Loud", "cannot be imported"),
        (".relative:Loud", "cannot be imported"),
        ("their_slip:Loud", "SyntaxError"),
        ("their_driver:Loud", "no board"),
        ("their_regressors:Picky", "Picky raised RuntimeError: no data is good enough"),
        ("their_regressors:Leaving", "fit of their_regressors:Leaving raised SystemExit: 0"),
        ("their_regressors:Odd", "predict of their_regressors:Odd raised OddError"),
        ("their_exit:Loud", "SystemExit: 0"),
        ("their_break:Loud", "KeyboardInterrupt"),
        ("their_regressors:", "cannot be imported"),
        ("their_regressors:Half", "is no regressor"),
        ("their_regressors:number", "is no regressor"),
        ("their_regressors:Broken", "one finite Shore A"),
        ("their_regressors", "their_regressors"),
    ],
)
def test_who_cannot_be_asked_is_refused(here: Path, capsys: Any, name: str, why: str) -> None:
    assert asked(name) == 2
    said = capsys.readouterr().err
    assert why in said
    assert said.count("\n") == 1
    assert not (here / "b").exists()


def test_results_of_something_else_are_not_written_over(here: Path, capsys: Any) -> None:
    (here / "b").mkdir()
    (here / "b" / "results.json").write_text(json.dumps({"study": {"asked": {}}}))
    assert asked("svm") == 2
    (here / "b" / "results.json").unlink()
    (here / "b" / "report.html").write_text("mine")
    assert asked("svm") == 2
    assert "choose another --out" in capsys.readouterr().err
    assert (here / "b" / "report.html").read_text() == "mine"


def test_other_words_are_refused(here: Path) -> None:
    assert asked("svm", "--seed", "-1") == 2
    assert run("benchmark", "svm", "--condition", "tropical") == 2
