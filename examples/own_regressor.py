"""A regressor of your own, in scikit-learn's form, asked 2 to 15 ms after contacts of the twin.

python examples/own_regressor.py
"""

import numpy as np

from firstcontact.learning.at_lengths import fit_at_lengths, from_class
from firstcontact.learning.rig_sets import rig_set


class Loudness:
    """What is hard is loud."""

    def fit(self, X, y):
        """X: the first samples after each contact, V, shape (n, samples)."""
        self.line = np.polyfit(np.log(X.std(axis=1)), y, 1)
        return self

    def predict(self, X):
        """Shore A, shape (n,)."""
        return np.polyval(self.line, np.log(X.std(axis=1)))


if __name__ == "__main__":
    rig = rig_set("paper-rig", seed=1, blocks=10, objects=2)
    learn, asked = rig.blocks, rig.objects
    model = fit_at_lengths(from_class(Loudness), learn.touches, learn.shore_a, learn.sessions)
    for samples in model.lengths:
        whole = asked.touches.valid >= samples
        answers = model.answers(asked.touches.take(whole).until(samples))
        error = answers.values - asked.shore_a[whole]
        print(
            f"{1e3 * samples / model.rate:4.1f} ms: RMSE {np.sqrt((error**2).mean()):.1f} Shore A"
        )
