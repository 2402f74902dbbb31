"""Quantities of labels: Shore A, modulus, stiffness and ranks."""

import numpy as np
import pytest

import firstcontact as fc
from firstcontact.core import InputError, fingertip_layout
from firstcontact.core.physics import gent_modulus
from firstcontact.core.quantity import MODULUS, QUANTITIES, RANK, SHORE_A, STIFFNESS


def dataset(*labels):
    data, layout = np.zeros((500, 16)), fingertip_layout()
    return fc.Dataset(tuple(fc.Pinch(data, layout, fc.Label(**label)) for label in labels))


@pytest.mark.parametrize("quantity", QUANTITIES.values(), ids=str)
def test_a_scale_is_undone(quantity):
    values = np.geomspace(max(quantity.least, 1e-3), quantity.most, 20)
    assert np.allclose(quantity.restored(quantity.scaled(values)), values, rtol=1e-12)


@pytest.mark.parametrize("quantity", [MODULUS, STIFFNESS])
def test_errors_of_a_logarithmic_quantity_are_factors(quantity):
    error = float(np.diff(quantity.scaled([5.0, 6.0]))[0])
    assert quantity.error_words(error) == "x1.20"
    assert quantity.error_words(-error) == "x0.83"


def test_a_modulus_is_a_shore_a_where_gents_formula_holds():
    moduli = [1e-6 * gent_modulus(shore) for shore in (2.0, 10.0, 60.0, 96.0)]
    data = dataset(*({"modulus_mpa": m} for m in moduli))
    assert data.quantity is MODULUS
    assert np.allclose(data.shore_a, [np.nan, 10, 60, np.nan], equal_nan=True)


@pytest.mark.parametrize(
    ("labels", "quantity"),
    [
        ([{}], None),
        ([{"hardness_rank": 2}], RANK),
        ([{"stiffness_n_per_mm": 2.0}, {}], STIFFNESS),
        ([{"shore_a": 20.0}, {"hardness_rank": 3}], SHORE_A),
    ],
)
def test_a_dataset_has_one_quantity(labels, quantity):
    assert dataset(*labels).quantity is quantity


@pytest.mark.parametrize("other", ["modulus_mpa", "stiffness_n_per_mm"])
def test_two_measured_quantities_in_a_dataset_are_refused(other):
    data = dataset({"shore_a": 20.0}, {other: 2.0})
    with pytest.raises(InputError, match=f"shore_a and {other}"):
        _ = data.quantity


@pytest.mark.parametrize("value", [0.0, -1.0, 2e6, np.nan, "stiff"])
@pytest.mark.parametrize("name", ["modulus_mpa", "stiffness_n_per_mm"])
def test_an_impossible_label_is_refused(name, value):
    with pytest.raises(InputError, match=name):
        fc.Label(**{name: value})
