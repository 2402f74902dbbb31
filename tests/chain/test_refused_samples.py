"""A chain names the fault of samples that it refuses, and goes on with the next ones."""

import numpy as np
import pytest
from numpy.typing import NDArray

from firstcontact.chain import Chain, build_image
from firstcontact.chain.image import NO_DETECTOR, DetectorConstants, DetectorKind
from firstcontact.core import Block, Channel, ChannelKind, Finger, Layout

LAYOUT = Layout((Channel("piezo", ChannelKind.VIBRATION, Finger.INDEX, "V"),), rate=1000.0)
SAMPLES = np.random.default_rng(1).standard_normal((50, 1))


@pytest.mark.parametrize("first", [-1, -(2**40)])
def test_a_negative_first_sample_is_no_wrong_width(first: int) -> None:
    chain = Chain(build_image(1000.0, NO_DETECTOR), LAYOUT)
    with pytest.raises(ValueError, match="first sample"):
        chain.take(Block(SAMPLES, first))
    assert chain.take(Block(SAMPLES, 0))


def test_a_chain_in_use_is_no_wrong_width() -> None:
    class Reentrant:
        def settled(self, quiet: NDArray[np.float64]) -> None:
            chain.take(Block(SAMPLES, 50))

        def fires(self, windows: NDArray[np.float64]) -> NDArray[np.bool_]:
            return np.zeros(windows.shape[:2], bool)

    constants = DetectorConstants(DetectorKind.PYTHON, 10, 2, 20, 5)
    chain = Chain(build_image(1000.0, constants), LAYOUT, detector=Reentrant())
    with pytest.raises(ValueError, match="in use"):
        chain.take(Block(SAMPLES, 0))
