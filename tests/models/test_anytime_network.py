"""Arrays of the network, and what a rig adds to it."""

import numpy as np
import pytest

from firstcontact.core import InputError
from firstcontact.models.model_file import pretrained
from firstcontact.models.rig.context_network import ContextNetwork
from firstcontact.models.rig.rigs import Rig

ARRAYS = pretrained().network.to_arrays()


def test_the_order_of_the_levels_does_not_matter() -> None:
    rng = np.random.default_rng(3)
    tokens, general = (
        rng.standard_normal((len(Rig.STAGES), 5, Rig.TOKEN)),
        rng.standard_normal(Rig.GENERAL),
    )
    network = ContextNetwork(ARRAYS)
    one, other = (network.rig_term(t, general) for t in (tokens, tokens[:, ::-1]))
    assert one.shape == (len(Rig.STAGES), network.directions)
    assert one == pytest.approx(other, abs=1e-4)


@pytest.mark.parametrize("levels", [0, 1, 8])
@pytest.mark.parametrize("far", [1e30, -1e30])
def test_rigs_that_are_far_out_stay_finite(levels: int, far: float) -> None:
    term = ContextNetwork(ARRAYS).rig_term(
        np.full((len(Rig.STAGES), levels, Rig.TOKEN), far), np.full(Rig.GENERAL, far)
    )
    assert np.isfinite(term).all()


def test_arrays_are_given_back() -> None:
    again = ContextNetwork(ARRAYS).to_arrays()
    assert again.keys() == ARRAYS.keys()
    for name, array in ARRAYS.items():
        assert again[name].dtype == array.dtype
        np.testing.assert_array_equal(array, again[name])


@pytest.mark.parametrize("name", ARRAYS)
def test_every_array_is_required_and_checked(name: str) -> None:
    array = ARRAYS[name]
    for bad in (array[:-1], array * np.nan, array[None]):
        with pytest.raises(InputError):
            ContextNetwork({**ARRAYS, name: bad})
    with pytest.raises(InputError, match="missing"):
        ContextNetwork({n: a for n, a in ARRAYS.items() if n != name})
