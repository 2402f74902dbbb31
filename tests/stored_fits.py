"""Fitted detectors that all processes of a test run share.

Most trainings in tests fit detectors to the same few sets of pinches. Each fit is computed once in
a test run, by its process that needs it first, and stored in a folder of that run.
"""

import os
import pickle
import sys
from collections.abc import Callable
from dataclasses import fields
from functools import wraps
from hashlib import sha256
from pathlib import Path
from typing import Any

from firstcontact.contact import SvmDetector, training
from firstcontact.contact.detector import TrainedDetector
from firstcontact.contact.logistic import LogisticDetector
from firstcontact.core import Dataset
from firstcontact.core.files import temporary_path

#: Variable with the folder of the fits. Processes that a test starts inherit it.
FOLDER = "FIRSTCONTACT_TEST_FITS"


def stored(fit: Callable[..., Any]) -> Callable[..., Any]:
    """Return a method ``fit`` of a detector that reuses equal fits of this test run.

    Parameters
    ----------
    fit
        Method of the detector's class. Its results depend on its arguments, on the constants of
        its module and of the modules that prepare its training data.
    """
    modules = (sys.modules[fit.__module__], training)

    @wraps(fit)
    def fitted(
        detector: TrainedDetector, dataset: Dataset, *words: object, **options: object
    ) -> Any:
        # A detector that is fitted again, and further groups of channels, have long arrays.
        if FOLDER not in os.environ or detector.trained or any(p.groups for p in dataset.pinches):
            return fit(detector, dataset, *words, **options)
        constants = [
            (name, value)
            for module in modules
            for name, value in sorted(vars(module).items())
            if name.isupper()
        ]
        arguments = (type(detector), vars(detector), words, options, constants)
        path = Path(os.environ[FOLDER], _digest(dataset, arguments))
        if path.is_file():
            vars(detector).update(pickle.loads(path.read_bytes()))
            return detector
        result = fit(detector, dataset, *words, **options)
        with temporary_path(path) as making:
            making.write_bytes(pickle.dumps(vars(detector)))
            making.rename(path)
        return result

    return fitted


def _digest(dataset: Dataset, arguments: object) -> str:
    """Return the SHA-256 of all that a fit depends on."""
    digest = sha256(repr(arguments).encode())
    for pinch in dataset.pinches:
        for field in fields(pinch):
            value = getattr(pinch, field.name)
            is_array = field.name == "data"
            digest.update(value.tobytes() if is_array else repr(value).encode())
            digest.update(f"{value.dtype}{value.shape}".encode() if is_array else b";")
    return digest.hexdigest()


#: Methods that fit the detectors which learn, by their full names.
FITS = {
    f"{detector.__module__}.{detector.__name__}.fit": stored(detector.fit)
    for detector in (LogisticDetector, SvmDetector)
}
