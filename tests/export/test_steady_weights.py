"""Steady state in C, sample by sample, compared with Python: with an offset, with a pure tone."""

from __future__ import annotations

import ctypes
import subprocess

import numpy as np
import pytest
from numpy.typing import NDArray

from firstcontact.chain import fit_predictions
from firstcontact.contact import make_detector
from firstcontact.contact._loudness import ORDER
from firstcontact.contact._steady_state import SteadyState
from firstcontact.core import Dataset
from firstcontact.export import Trained
from firstcontact.export import _c_library as c_library
from firstcontact.testing._closings import closing

#: Says what a steady state of both channels gave: mean, sigma and weights of each.
ASKED = """
#include "fc_detector.h"
void ask(const double *volts, double *told)
{
    static fc_detector d;
    fc_contact contacts[FC_CHANNELS];
    fc_detector_start(&d, 0);
    for (int32_t n = 0; n < FC_STEADY; n++)
        (void)fc_detector_take(&d, volts + n * FC_CHANNELS, contacts);
    for (int32_t k = 0; k < FC_CHANNELS; k++) {
        *told++ = d.channel[k].first + d.channel[k].mean;
        *told++ = d.channel[k].sigma;
        for (int32_t i = 0; i <= FC_ORDER; i++)
            *told++ = d.channel[k].judge.weight[i];
    }
}
"""


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> ctypes.CDLL:
    folder = tmp_path_factory.mktemp("steady")
    detector = make_detector("logistic").fit(Dataset(tuple(closing(seed) for seed in range(24))))
    c_library.write(Trained(detector=detector), folder)
    (folder / "ask.c").write_text(ASKED, encoding="utf-8")
    sources = [str(folder / "ask.c"), *map(str, sorted((folder / "src").glob("*.c")))]
    options = ["-std=c99", "-O2", "-ffp-contract=off", "-shared", "-fPIC", f"-I{folder / 'src'}"]
    made = folder / "steady.so"
    subprocess.run(["gcc", *options, *sources, "-lm", "-o", str(made)], check=True)
    return ctypes.CDLL(str(made))


def measure(library: ctypes.CDLL, volts: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return mean, sigma and weights of each channel, shape (2, ORDER + 3)."""
    volts, out = np.ascontiguousarray(volts), np.empty((2, ORDER + 3))
    library.ask(*(x.ctypes.data_as(ctypes.c_void_p) for x in (volts, out)))
    return out


def quiet(kind: str, rng: np.random.Generator) -> NDArray[np.float64]:
    n = 197
    noise = rng.standard_normal((n, 2))
    if kind == "motor":
        t = np.arange(n)[:, None] / 4936.0
        lines = np.sin(2 * np.pi * 150.0 * t) + 0.3 * np.sin(2 * np.pi * 610.0 * t + 1)
        return lines + 0.05 * noise
    if kind == "drifts":
        return np.cumsum(noise, axis=0)
    if kind == "begins with a knock":
        noise[0] = 1000.0
    if kind == "ends with a knock":
        noise[-1] = 1000.0
    if kind == "steps":
        return np.round(2.0 * noise) * 0.01
    return noise


@pytest.mark.parametrize(
    "kind", ["white", "motor", "drifts", "begins with a knock", "ends with a knock", "steps"]
)
@pytest.mark.parametrize(("scale", "offset"), [(1.0, 0.0), (1e-6, 0.0), (1e3, 0.0), (1e-3, 1.65)])
def test_weights_are_those_of_python(
    library: ctypes.CDLL, kind: str, scale: float, offset: float
) -> None:
    rng = np.random.default_rng(5)
    for _ in range(5):
        volts = scale * quiet(kind, rng) + offset
        state = SteadyState.measure(volts)
        x = state.normalise(volts)
        got = measure(library, volts)
        np.testing.assert_allclose(got[:, 0], state.mean, rtol=1e-12, atol=1e-12 * scale)
        np.testing.assert_allclose(got[:, 1], state.sigma, rtol=1e-11)
        wanted = fit_predictions(x.T)
        np.testing.assert_allclose(got[:, 2:], wanted, rtol=0, atol=1e-8 * np.abs(wanted).max())


def test_a_pure_tone_leaves_little_and_still_its_sigma(library: ctypes.CDLL) -> None:
    """The prediction cancels a tone to a thousandth, so rounding errors show most in it."""
    tone = np.sin(0.3 * np.arange(197))[:, None] * np.array([1.0, 0.01])
    x = SteadyState.measure(tone).normalise(tone)
    wanted = fit_predictions(x.T)
    np.testing.assert_allclose(measure(library, tone)[:, 2:], wanted, rtol=1e-7)


@pytest.mark.parametrize("offset", [0.0, 1.65, -0.25])
def test_a_channel_that_does_not_move_foretells_nothing(
    library: ctypes.CDLL, offset: float
) -> None:
    got = measure(library, np.full((197, 2), offset))
    np.testing.assert_array_equal(got[:, 0], offset)
    assert np.isinf(got[:, 1]).all()
    assert not got[:, 2:].any()
