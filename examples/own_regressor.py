"""Your own scikit-learn regressors: train one, and score it on simulated objects.

python examples/own_regressor.py
"""

from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from sklearn.linear_model import Ridge
from sklearn.pipeline import make_pipeline
from sklearn.preprocessing import FunctionTransformer, StandardScaler

import firstcontact as fc
from firstcontact.models.labelled_data import LabelledTouches
from firstcontact_lab.study.scores import predictions_by_time
from firstcontact_lab.study.window_ladder import fit_window_ladder


class Loudness:
    """Regressor that predicts stiffness from loudness alone."""

    def fit(self, X, y):
        """Fit a line to the logarithm of the loudness.

        X holds the first samples after each contact, V, shape (n, samples); y is in Shore A.
        """
        self.line = np.polyfit(np.log(X.std(axis=1)), y, 1)
        return self

    def predict(self, X):
        """Return the predicted Shore A of each contact, shape (n,)."""
        return np.polyval(self.line, np.log(X.std(axis=1)))


#: Log spectrum, then ridge regression. On the command line its name is own_regressor:pipeline.
pipeline = make_pipeline(
    FunctionTransformer(lambda X: np.log(np.abs(np.fft.rfft(X)) + 1e-6)),
    StandardScaler(),
    Ridge(10),
)


if __name__ == "__main__":
    with TemporaryDirectory() as folder:
        fc.simulate(Path(folder, "pinches"), pinches_per_block=12, pinches_per_object=3)
        pinches = fc.load(Path(folder, "pinches"))
    contacts = LabelledTouches.cut(pinches, [pinch.first for pinch in pinches])
    unseen = pinches.test[contacts.rows]
    learned, asked = contacts.take(~unseen), contacts.take(unseen)
    model = fit_window_ladder(Loudness(), learned.touches, learned.shore_a)
    for ms, predicted in predictions_by_time(model, asked.touches).items():
        print(f"{ms} ms: RMSE {np.sqrt(np.mean((predicted.value - asked.shore_a) ** 2)):.1f}")
