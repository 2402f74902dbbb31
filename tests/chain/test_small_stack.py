"""The compiled functions run in threads with a small stack, as those of musl are."""

import subprocess
import sys

import pytest

PROGRAM = """
import threading
import numpy as np
from firstcontact.chain.touch import fit_predictions, look_features
quiet = np.random.default_rng(0).normal(size=(3, 200))
weights = fit_predictions(quiet)
calls = {{
    "fit": lambda: fit_predictions(quiet),
    "look": lambda: look_features(quiet, weights, (1, 2, 3, 4, 5, 8), 1.0),
}}
wanted, made = calls["{call}"](), []
threading.stack_size(1 << 17)
thread = threading.Thread(target=lambda: made.append(calls["{call}"]()))
thread.start()
thread.join()
np.testing.assert_array_equal(made[0], wanted)
"""


@pytest.mark.parametrize("call", ["fit", "look"])
def test_training_of_a_detector_runs_in_a_thread_of_128_kb(call: str) -> None:
    subprocess.run([sys.executable, "-c", PROGRAM.format(call=call)], check=True)
