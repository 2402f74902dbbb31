"""Estimator around any scikit-learn regressor or classifier, whose models skops saves.

skops writes objects as a ZIP file of JSON and arrays. Only types that skops trusts, and types in
``TRUSTED``, are restored. No code in the file runs.
"""

from __future__ import annotations

import inspect
import io
import re
import sys
from collections.abc import Callable, Mapping
from copy import deepcopy
from dataclasses import dataclass
from importlib import import_module
from typing import Any, ClassVar, Self
from zipfile import ZipFile, ZipInfo

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import ArgumentError, InputError, ModelError
from firstcontact.core.registry import foreign_errors
from firstcontact.core.text import summarize_error
from firstcontact.models.estimator import Estimator, training_spec
from firstcontact.models.values import Arrays, Task, Values, Windows
from firstcontact.models.windows.window_model import Spec, WindowModel

#: Types of scikit-learn that hold numbers only and are trusted in addition to those of skops: trees
#: of forests and boosting, and kernels of Gaussian processes.
TRUSTED = (
    "sklearn.tree._tree.Tree",
    "sklearn.ensemble._hist_gradient_boosting.predictor.TreePredictor",
    *(
        f"sklearn.gaussian_process.kernels.{kernel}"
        for kernel in (
            *("CompoundKernel", "ConstantKernel", "DotProduct", "ExpSineSquared"),
            *("Exponentiation", "Matern", "Product", "RBF", "RationalQuadratic", "Sum"),
            "WhiteKernel",
        )
    ),
)
_SCHEMA = "schema.json"
#: Addresses of objects, and of their arrays' files, in the schema.
_ADDRESS = re.compile(r'(?<="__id__": )\d+|(?<="file": ")\d+')


class RegressorModel(WindowModel):
    """Window model around a fitted scikit-learn regressor or classifier."""

    kind: ClassVar[str] = "sklearn"
    modules: ClassVar[tuple[str, ...]] = ("skops",)
    extra: ClassVar[str] = "train"

    def __init__(self, spec: Spec, fitted: Any, title: str = "") -> None:
        self.spec = spec
        self._fitted = fitted
        self._title = title or type(fitted).__name__

    @property
    def name(self) -> str:
        return class_name(self._title)

    @property
    def notes(self) -> Mapping[str, Any]:
        return {"regressor": self._title}

    def outputs(self, X: Windows) -> NDArray[Any]:
        """Return predictions (n, 1), or 1 at the predicted class and 0 elsewhere, (n, classes)."""
        if not len(X):
            return np.zeros((0, len(self.spec.classes) or 1))
        with foreign_errors(f"{self._title}.predict"):
            answer = self._fitted.predict(flat(X))
            predicted: Values = np.asarray(answer, dtype=np.float64).reshape(-1, 1)
        if len(predicted) != len(X):
            raise ModelError(
                f"{self._title} returned {len(predicted)} numbers for {len(X)} windows: "
                "predict(X) must return one number for each window"
            )
        if self.spec.task is Task.CLASSIFICATION:
            chosen: Values = (predicted == np.array(self.spec.classes)).astype(np.float64)
            return chosen
        return predicted

    def to_arrays(self) -> Arrays:
        """Return one array: the bytes of a skops file that holds the regressor."""
        return {
            "skops": np.frombuffer(to_skops(self._fitted, self._title), np.uint8),
            "title": np.frombuffer(self._title.encode(), np.uint8),
        }

    @classmethod
    def from_arrays(cls, spec: Spec, arrays: Arrays) -> Self:
        title = arrays["title"].tobytes().decode(errors="replace")[:200]
        fitted = from_skops(arrays["skops"].tobytes())
        if not callable(getattr(fitted, "predict", None)):
            raise ModelError("the skops file holds no object with predict(X): train again")
        return cls(spec, fitted, title)


@dataclass(frozen=True)
class RegressorEstimator(Estimator):
    """Base class of the estimators that :func:`regressor_estimator` makes from regressors."""

    model: ClassVar[type[WindowModel]] = RegressorModel
    modules: ClassVar[tuple[str, ...]] = ("skops",)
    extra: ClassVar[str] = "train"
    #: Class or instance of a regressor.
    regressor: ClassVar[Any]

    def fit(
        self, X: Windows, y: Values, groups: NDArray[Any] | None = None, seed: int = 0
    ) -> RegressorModel:
        """Fit the regressor to windows flattened by :func:`flat`; see :meth:`Estimator.fit`."""
        spec = training_spec(self.task, self.rate, X, y, groups)
        fraction = next((level for level in spec.classes if level % 1), None)
        if fraction is not None:
            raise ArgumentError(
                f"scikit-learn's classifiers need whole numbers as classes, but a label is "
                f"{fraction:g}: choose another estimator, or a regression",
                parameter="estimator",
            )
        with foreign_errors(f"{self.title}.fit"):
            unfitted = fresh(self.regressor, seed)
            fitted = unfitted.fit(flat(X), y.copy())
        return RegressorModel(spec, unfitted if fitted is None else fitted, self.title)


def regressor_estimator(regressor: Any, name: str = "") -> type[RegressorEstimator]:
    """Return an estimator class around a scikit-learn regressor or classifier.

    ``regressor`` is a class or an instance, and ``name`` the name of the estimator, by default that
    of the class. Raise ArgumentError if ``regressor`` has no methods ``fit`` and ``predict``.
    """
    kind = regressor if isinstance(regressor, type) else type(regressor)
    title = name or kind.__name__
    with foreign_errors(title):
        fits = all(callable(getattr(regressor, method, None)) for method in ("fit", "predict"))
        task = Task.CLASSIFICATION if _is_classifier(regressor) else Task.REGRESSION
    if not fits:
        raise ArgumentError(
            f"{title} is not a regressor: give a class or an instance with fit(X, y) and predict(X)"
        )
    attributes = {"name": title, "title": title, "tasks": (task,), "regressor": regressor}
    return type("RegressorEstimator", (RegressorEstimator,), attributes)


def imported(name: str) -> Any:
    """Import and return the regressor that ``PACKAGE:NAME`` names. This runs code of its package.

    Raise ArgumentError if the import fails.
    """
    module, _, path = name.partition(":")
    try:
        if "" not in sys.path:
            sys.path.append("")  # modules of the working folder, after all others
        regressor: Any = import_module(module)
        for part in path.split("."):
            regressor = getattr(regressor, part)
    except Exception as error:
        raise ArgumentError(
            f"{name} cannot be imported ({summarize_error(error)}): write it as PACKAGE:NAME, and "
            "make sure that Python finds the package"
        ) from error
    return regressor


def named_estimator(name: str) -> type[RegressorEstimator]:
    """Return an estimator class around the regressor that ``PACKAGE:NAME`` names."""
    return regressor_estimator(imported(name), name)


def class_name(estimator: str) -> str:
    """Return the class name in ``PACKAGE:NAME``. Any other name is returned unchanged."""
    _, colon, path = estimator.partition(":")
    return path.rpartition(".")[2] if colon else estimator


def fresh(regressor: Any, seed: int) -> Any:
    """Return an unfitted copy of a regressor, which has this random seed unless it states one."""
    if isinstance(regressor, type):
        return regressor(**({"random_state": seed} if _takes_seed(regressor) else {}))
    if not hasattr(regressor, "get_params"):
        return deepcopy(regressor)
    from sklearn.base import clone

    model = clone(regressor)
    states = [n for n in model.get_params() if n.rpartition("__")[2] == "random_state"]
    free = [n for n in states if model.get_params()[n] is None]
    return model.set_params(**dict.fromkeys(free, seed))


def flat(X: Windows) -> NDArray[np.float64]:
    """Return windows (n, samples, channels) as rows (n, samples * channels)."""
    rows: NDArray[np.float64] = X.transpose(0, 2, 1).reshape(len(X), -1).astype(np.float64)
    return rows


def to_skops(fitted: Any, title: str) -> bytes:
    """Return a fitted regressor as the bytes of a skops file. Equal objects give equal bytes.

    ``title`` names it in errors. Raise ArgumentError if skops cannot save it.
    """
    from skops.io import dumps

    try:
        raw = dumps(fitted)
    except Exception as error:
        raise ArgumentError(
            f"{title} cannot be saved by skops ({summarize_error(error)}): choose another regressor"
        ) from None
    _check_types(raw, title)
    return _number_objects(raw)


def from_skops(raw: bytes) -> Any:
    from skops.io import loads

    try:
        _check_types(raw, "the skops file")
        return loads(raw, trusted=list(TRUSTED))
    except InputError:
        raise
    except Exception as error:
        raise ModelError(
            f"the skops file is damaged ({summarize_error(error)[:200]}): train again"
        ) from None


def _check_types(raw: bytes, title: str) -> None:
    from skops.io import get_untrusted_types

    unknown = sorted(set(get_untrusted_types(data=raw)) - set(TRUSTED))
    if unknown:
        raise ArgumentError(
            f"{title} holds the type {', '.join(unknown[:5])}, which is not trusted: use the "
            "trusted types of scikit-learn, SciPy and NumPy, or write an estimator",
            parameter="estimator",
        )


def _number_objects(raw: bytes) -> bytes:
    """Return the bytes of a skops file in which numbers replace the memory addresses of objects."""
    numbers: dict[str, str] = {}
    buffer = io.BytesIO()
    with ZipFile(io.BytesIO(raw)) as archive, ZipFile(buffer, "w") as renumbered:
        schema = _ADDRESS.sub(
            lambda match: numbers.setdefault(match[0], str(len(numbers))),
            archive.read(_SCHEMA).decode(),
        )
        for address, number in numbers.items():
            for name in (n for n in archive.namelist() if n.startswith(f"{address}.")):
                renumbered.writestr(ZipInfo(name.replace(address, number)), archive.read(name))
        renumbered.writestr(ZipInfo(_SCHEMA), schema)
    return buffer.getvalue()


def _is_classifier(regressor: Any) -> bool:
    """Return True for a scikit-learn classifier, given as an instance or a class."""
    if isinstance(regressor, type):
        from sklearn.base import ClassifierMixin

        return issubclass(regressor, ClassifierMixin)
    if not hasattr(regressor, "__sklearn_tags__"):
        return False
    from sklearn.base import is_classifier

    return bool(is_classifier(regressor))


def _takes_seed(regressor: Callable[..., Any]) -> bool:
    try:
        return "random_state" in inspect.signature(regressor).parameters
    except ValueError:  # a class written in C has no signature
        return False
