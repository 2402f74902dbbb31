"""Registry of estimators. To add an estimator, write one file and add one line here."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from firstcontact.core import ArgumentError, ModelError, Registry

# The help of a command lists the names, and does not wait for NumPy.
if TYPE_CHECKING:
    from firstcontact.models.estimator import Estimator, EstimatorInfo
    from firstcontact.models.values import Task

#: Classes of estimators by name, including those of plug-ins.
ESTIMATORS: Registry[type[EstimatorInfo]] = Registry(
    "estimator",
    "firstcontact.estimators",
    {
        "train_mean": "firstcontact.models.windows.baselines:TrainMean",
        "peak": "firstcontact.models.windows.baselines:Peak",
        "svm": "firstcontact.models.windows.svm:Svm",
        "cnn": "firstcontact.models.windows.cnn:Cnn",
        "log_spectrum": "firstcontact.models.windows.log_spectrum:LogSpectrum",
        "network": "firstcontact.models.rig.network_estimator:NetworkEstimator",
        "combined": "firstcontact.models.rig.combined:CombinedEstimator",
    },
    default="svm",
    base="firstcontact.models.estimator:EstimatorInfo",
    maker="firstcontact.models.windows.regressor:named_estimator",
)


def window_estimators() -> dict[str, type[Estimator]]:
    """Return the registered estimators that learn from windows, by name."""
    from firstcontact.models.estimator import Estimator

    return {name: entry for name, entry in ESTIMATORS.items() if issubclass(entry, Estimator)}


def model_class(kind: str, *, of_windows: bool) -> Any:
    """Return the class of models that ``kind``, a field of their cards, names.

    ``of_windows`` is True for window models, False for any-time models. Raise ModelError if no
    installed package has this kind.
    """
    from firstcontact.models.estimator import Estimator
    from firstcontact.models.windows.regressor import RegressorModel  # its imports are slow

    if of_windows and kind == RegressorModel.kind:
        return RegressorModel
    # The package's own kinds come first, so that no plug-in is imported for them.
    for entry in ESTIMATORS.values():
        named = entry.model.kind if of_windows else entry.name
        if issubclass(entry, Estimator) is of_windows and named == kind:
            return entry.model
    raise ModelError(f"the kind of model {kind!r} is unknown: install the package that made it")


def find_estimator(estimator: object) -> type[EstimatorInfo]:
    from firstcontact.models.estimator import EstimatorInfo
    from firstcontact.models.windows.regressor import regressor_estimator

    if isinstance(estimator, str):
        return ESTIMATORS.find(estimator)
    if isinstance(estimator, type) and issubclass(estimator, EstimatorInfo):
        return estimator
    return regressor_estimator(estimator)


def make_estimator(estimator: object, task: Task, rate: float, **options: Any) -> Estimator:
    """Return an unfitted estimator for windows with the sampling ``rate``, Hz.

    ``estimator`` is a name, an estimator's class, or a scikit-learn regressor. ``options`` set
    fields of the estimator, such as ``epochs`` of the CNN. Raise InputError if there is no such
    estimator, or it cannot learn from windows or does not support the task.
    """
    from firstcontact.models.estimator import Estimator

    entry = find_estimator(estimator)
    with ESTIMATORS.convert_errors(entry.name):
        if not issubclass(entry, Estimator):
            raise ArgumentError(
                f"{entry.name} cannot be fitted to windows, because it needs whole contacts: use "
                "firstcontact.train or firstcontact.adapt",
                parameter="estimator",
            )
        if task not in entry.tasks:
            raise ArgumentError(
                f"{entry.name} does not support {task}: choose {' or '.join(entry.tasks)}"
            )
        return entry(task, rate, **options)
