"""What the paper reports, in one place.

Source: A. S. Pimpalkar, A. Slepyan, N. V. Thakor, "At First Contact: Stiffness
Estimation Using Vibrational Information for Prosthetic Grasp Modulation".
Sections are given with each value. A study prints these beside its own numbers
and never computes with them.
"""

from __future__ import annotations

from typing import NamedTuple


class Target(NamedTuple):
    """Least share of windows and of pinches, and longest median delay, ms."""

    windows: float
    pinches: float
    delay: float


#: Shore A of the blocks (section III-A).
BLOCKS = (10.0, 20.0, 29.0, 43.0, 60.0)
#: From the first to the second contact, ms (section IV).
OFFSET_MEAN = 16.65
OFFSET_SD = 10.35
#: "Accuracy" of contact detection (section IV); what is counted is not said.
CONTACT = {"three_sigma": 0.906, "svm": 1.0}
#: The project's own target for the detector that the paper finds perfect: least share of windows
#: and of pinches, and longest median delay.
TARGET = {"svm": Target(windows=0.999, pinches=0.995, delay=3.0)}
#: Accuracy over the five blocks, random 90-10 split (section IV).
ACCURACY = {"svm": 0.972, "cnn": 0.986}
#: Called "MSE" and given in Shore A, over the eight objects (section IV). As an
#: MSE its unit would be Shore A squared; which was meant cannot be told.
OBJECT_ERROR = {"svm": 4.17, "cnn": 2.39}
#: Inference time of one window, ms, on a computer not named (section IV).
INFERENCE = {"svm": "< 1", "cnn": "1.4"}
