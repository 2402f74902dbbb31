"""Registry of estimators. To add an estimator, write one file and add one line here."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from firstcontact.core import InputError, Registry

if TYPE_CHECKING:
    from firstcontact.models._estimator import Estimator
    from firstcontact.models._in_context import InContextModel
    from firstcontact.models._network_estimator import NetworkEstimator
    from firstcontact.models._spec import Task
    from firstcontact.models._window_model import WindowModel

ESTIMATORS: Registry[type[Estimator]] = Registry(
    "estimator",
    "firstcontact.estimators",
    {
        "train_mean": "firstcontact.models._baselines:TrainMean",
        "peak": "firstcontact.models._baselines:Peak",
        "svm": "firstcontact.models._svm:Svm",
        "cnn": "firstcontact.models._cnn:Cnn",
        "log_spectrum": "firstcontact.models._log_spectrum:LogSpectrum",
        "network": "firstcontact.models._network_estimator:NetworkEstimator",
        "combined": "firstcontact.models._combined:CombinedEstimator",
    },
    default="svm",
    base="firstcontact.models._estimator:Estimator",
    maker="firstcontact.models._regressor:named_estimator",
)


def model_kind(kind: str) -> type[WindowModel]:
    """Return the class of window models with this ``kind`` in their cards."""
    from firstcontact.models._regressor import RegressorModel

    if kind == RegressorModel.kind:
        return RegressorModel
    # The package's own kinds come first, so that no plug-in is imported for them.
    models = (entry.model for entry in ESTIMATORS.values() if entry.takes_windows)
    model_class = next((model for model in models if model.kind == kind), None)
    if model_class is None:
        kinds = ", ".join(entry.model.kind for entry in window_estimators().values())
        raise InputError(f"the kind of model {kind!r} is unknown (known: {kinds})")
    return model_class


def anytime_kind(kind: str) -> type[InContextModel]:
    """Return the class of any-time models with this ``kind`` in their cards."""
    from firstcontact.models._network_estimator import NetworkEstimator

    for name in ESTIMATORS.names:  # one by one: the package's own need no plug-in
        entry = ESTIMATORS.get(name)
        if entry is None or not issubclass(entry, NetworkEstimator):
            continue
        model: type[InContextModel] = entry.model
        if model.kind == kind:
            return model
    raise InputError(f"the kind of network {kind!r} is unknown: install the package that made it")


def window_estimators() -> dict[str, type[Estimator]]:
    """Return the registered estimators that learn from windows, by name."""
    return {name: entry for name, entry in ESTIMATORS.items() if entry.takes_windows}


def rig_estimators() -> dict[str, type[NetworkEstimator]]:
    """Return the registered estimators that learn from whole contacts, by name."""
    from firstcontact.models._network_estimator import NetworkEstimator

    return {n: entry for n, entry in ESTIMATORS.items() if issubclass(entry, NetworkEstimator)}


def find_estimator(estimator: object) -> type[Estimator]:
    """Return an estimator class.

    Parameters
    ----------
    estimator
        Name in :data:`ESTIMATORS`; ``PACKAGE:NAME`` of a class to import; an estimator class; or a
        regressor or classifier with scikit-learn's interface, as a class or an instance such as a
        pipeline.

    Raises
    ------
    InputError
        No estimator has this name, or the object lacks ``fit`` and ``predict``.
    """
    from firstcontact.models._estimator import Estimator
    from firstcontact.models._regressor import regressor_estimator

    if isinstance(estimator, str):
        return ESTIMATORS.find(estimator)
    if isinstance(estimator, type) and issubclass(estimator, Estimator):
        return estimator
    return regressor_estimator(estimator)


def make_estimator(estimator: object, task: Task, rate: float, **options: Any) -> Estimator:
    """Return an unfitted estimator.

    Parameters
    ----------
    estimator
        As in :func:`find_estimator`.
    task, rate
        Learning task, and sampling rate of the windows, Hz.
    options
        Values for further fields of the estimator, such as those in its ``quick``.

    Raises
    ------
    InputError
        No estimator has this name, or it does not support the task.
    """
    entry = find_estimator(estimator)
    with ESTIMATORS.calling(entry.name):
        if task not in entry.tasks:
            raise InputError(
                f"{entry.name} does not support {task}: choose {' or '.join(entry.tasks)}"
            )
        return entry(task, rate, **options)
