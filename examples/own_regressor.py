"""Your own scikit-learn regressors, compared with the package's on a small simulated set.

python examples/own_regressor.py
"""

import numpy as np
from sklearn.linear_model import Ridge
from sklearn.pipeline import make_pipeline
from sklearn.preprocessing import FunctionTransformer, StandardScaler

from firstcontact.core.jobs import Serial
from firstcontact_lab.study.benchmark import QUICK, benchmark


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
    results = benchmark("own_regressor:Loudness", "paper-rig", QUICK, 0, Serial())
    for name, scores in results.anytime.items():
        print(name, {f"{ms} ms": round(rmse, 1) for ms, rmse in scores.rmse.items()})
