"""Types of arrays, and the two learning tasks of all models."""

from __future__ import annotations

from enum import StrEnum
from typing import Any

import numpy as np
from numpy.typing import NDArray

#: Arrays of a model by their names in its file.
Arrays = dict[str, NDArray[Any]]
#: Signals after contacts, V, shape (n, samples, channels).
Windows = NDArray[np.float32]
Values = NDArray[np.float64]


class Task(StrEnum):
    """Learning task of an estimator: regression or classification."""

    REGRESSION = "regression"
    CLASSIFICATION = "classification"
