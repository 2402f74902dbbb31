"""All estimators and the runtimes of their models by name.

A new estimator is one file and one line in each table.
"""

from __future__ import annotations

from typing import Any

from firstcontact.core import InputError
from firstcontact.stiffness.baselines import ConstantModel, Peak, PeakModel, TrainMean
from firstcontact.stiffness.cnn import Cnn
from firstcontact.stiffness.cnn_model import CnnModel
from firstcontact.stiffness.estimator import Estimator
from firstcontact.stiffness.model import Model
from firstcontact.stiffness.spec import Task
from firstcontact.stiffness.svm import Svm
from firstcontact.stiffness.svm_model import SvmModel

ESTIMATORS: dict[str, type[Any]] = {
    TrainMean.name: TrainMean,
    Peak.name: Peak,
    Svm.name: Svm,
    Cnn.name: Cnn,
}

MODELS: dict[str, type[Model]] = {
    model.kind: model for model in (ConstantModel, PeakModel, SvmModel, CnnModel)
}


def make_estimator(name: str, task: Task, rate: float, **options: Any) -> Estimator:
    """An estimator that has learned nothing yet.

    Parameters
    ----------
    name
        One of :data:`ESTIMATORS`.
    task, rate
        What it is to learn, and the sampling rate of its windows in Hz.
    options
        Further fields of the estimator, such as ``epochs`` of the CNN.

    Raises
    ------
    InputError
        When there is none of that name.
    """
    if name not in ESTIMATORS:
        raise InputError(f"no estimator is called {name!r}: choose one of {', '.join(ESTIMATORS)}")
    estimator: Estimator = ESTIMATORS[name](task, rate, **options)
    return estimator
