"""Comparison of contact times from a high-speed camera with those from the contact strips."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from firstcontact.core import ArgumentError, FileError, Finger
from firstcontact.core.text import parse_float, parse_int, percent
from firstcontact.recording import Recording
from firstcontact.recording.table import read_rows

COLUMNS = ("pinch", "finger", "time_s")
#: Fewest pinches to which offset and drift of the clocks are fitted.
LEAST = 3
#: Longest film, s, and highest frame rate, Hz.
LONGEST, FASTEST = 1e7, 1e7

#: Pinch and finger.
Key = tuple[int, Finger]


@dataclass(frozen=True, slots=True)
class Agreement:
    """Agreement of the camera's contact times with the device's.

    ``residuals`` are the camera's times minus the device's, s, by pinch and finger, after the
    clocks' ``offset``, s, and ``drift`` were removed. ``left_out`` are contacts that only the
    camera has.
    """

    residuals: Mapping[Key, float]
    fps: float
    offset: float
    drift: float
    drift_error: float
    left_out: tuple[Key, ...]

    @property
    def within(self) -> float:
        """Share of contacts whose two times differ by at most one frame, 0 to 1."""
        return 1.0 - len(self.disagreeing_contacts) / len(self.residuals)

    @property
    def disagreeing_contacts(self) -> tuple[Key, ...]:
        """Contacts (pinch, finger) whose two times differ by more than one frame."""
        return tuple(k for k, r in self.residuals.items() if abs(r) > 1.0 / self.fps)


def read_contacts(path: Path) -> dict[Key, float]:
    """Read contact times by the camera from a CSV with the columns pinch, finger and time_s.

    Return the times, s, by number of the pinch and finger.
    """
    contacts: dict[Key, float] = {}
    for line, row in read_rows(path, COLUMNS):
        try:
            key = parse_int(row["pinch"]), Finger[row["finger"].upper()]
            time = parse_float(row["time_s"])
            if not abs(time) <= LONGEST:
                raise ValueError
        except (KeyError, ValueError) as error:
            raise FileError(
                f"{path}, line {line}: give a pinch's number, the finger (index or thumb), and a "
                "time in s"
            ) from error
        if key in contacts:
            raise FileError(f"{path}, line {line}: this contact is listed twice: keep one")
        contacts[key] = time
    return contacts


def compare(recording: Recording, contacts: Mapping[Key, float], fps: float = 960.0) -> Agreement:
    """Compare the camera's contact times with those of the strips in a recording.

    The offset and the drift between the two clocks are fitted first. ``contacts`` are the camera's
    times, s, by pinch and finger, and ``fps`` is its number of frames per second. Raises FileError
    for fewer than three pinches with both times.
    """
    if not 1.0 <= fps <= FASTEST:
        raise ArgumentError(f"fps is {fps:g}: give the camera's frames per s, 1 to {FASTEST:g}")
    rate = recording.header.layout.rate
    device: dict[Key, tuple[int, float]] = {
        (mark.number, c.finger): (mark.epoch, c.sample / rate)
        for mark in recording.pinches
        for c in mark.truth
        if c.finger is not None
    }
    both = [key for key in contacts if key in device]
    if (count := len({number for number, _ in both})) < LEAST:
        raise FileError(
            f"{recording.path}: only {count} pinches have contacts both from "
            f"the strips and from the camera, but {LEAST} are needed: check the pinch numbers"
        )
    epochs = sorted({device[key][0] for key in both})
    epoch = np.array([epochs.index(device[key][0]) for key in both])
    time = np.array([device[key][1] for key in both])
    seen = np.array([contacts[key] for key in both])
    centre = np.array([time[epoch == k].mean() for k in range(len(epochs))])
    design = np.column_stack([epoch[:, None] == np.arange(len(epochs)), time - centre[epoch]])
    difference = seen - time
    start = [*(float(np.median(difference[epoch == k])) for k in range(len(epochs))), 0.0]
    robust = least_squares(
        lambda p: (design @ p - difference) * fps, start, loss="soft_l1", x_scale="jac"
    ).x
    # The robust fit is close to a median. The camera's times are spread evenly over a frame, so the
    # mean is wanted: fit least squares to the contacts near the robust line.
    near = np.abs(design @ robust - difference) <= 2.0 / fps
    fitted, error = _least_squares(design, difference, near, robust)
    residuals = difference - design @ fitted
    return Agreement(
        dict(zip(both, residuals.tolist(), strict=True)),
        fps,
        float(fitted[0] - fitted[-1] * centre[0]),
        float(fitted[-1]),
        error,
        tuple(key for key in contacts if key not in device),
    )


def _least_squares(
    design: NDArray[np.float64],
    difference: NDArray[np.float64],
    near: NDArray[np.bool_],
    otherwise: NDArray[np.float64],
) -> tuple[NDArray[np.float64], float]:
    """Fit the offset and the drift between two clocks by least squares.

    ``difference`` has a time difference for each contact, s, and ``design`` a row for each contact.
    ``near`` is a mask of the contacts to use. Return the fitted parameters and the standard error
    of the drift. If there are too few contacts, return ``otherwise`` and NaN.
    """
    a, b = design[near], difference[near]
    fitted, _, rank, _ = np.linalg.lstsq(a, b, rcond=None)
    if len(a) <= a.shape[1] or rank < a.shape[1]:
        return otherwise, math.nan
    variance = float(np.sum((b - a @ fitted) ** 2)) / (len(a) - a.shape[1])
    return np.asarray(fitted, np.float64), math.sqrt(
        variance * float(np.linalg.inv(a.T @ a)[-1, -1])
    )


def in_words(agreement: Agreement) -> Sequence[str]:
    """Return the results of a comparison as lines of text."""
    frame = 1e3 / agreement.fps
    sizes = 1e3 * np.abs(list(agreement.residuals.values()))
    lines = [
        f"contacts    {len(agreement.residuals)} in both lists",
        f"agreement   {percent(agreement.within)} within one frame of {frame:.2f} ms; median "
        f"{np.median(sizes):.2f} ms, largest {sizes.max():.2f} ms",
        f"clocks      camera - device {agreement.offset:+.4f} s at sample 0, drift "
        f"{1e6 * agreement.drift:+.1f} ppm (standard error {1e6 * agreement.drift_error:.1f} ppm)",
    ]
    for number, finger in agreement.disagreeing_contacts:
        off = 1e3 * agreement.residuals[number, finger]
        lines.append(f"disagrees   pinch {number}, {finger.name.lower()}: camera {off:+.2f} ms")
    for number, finger in agreement.left_out:
        lines.append(f"left out    pinch {number}, {finger.name.lower()}: no strip closed there")
    return lines
