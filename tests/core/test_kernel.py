"""RBF kernel: equal to scikit-learn's, in the precision of its vectors."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from sklearn.metrics.pairwise import rbf_kernel

from firstcontact.core.kernel import RbfKernel


@pytest.mark.parametrize(("kind", "close"), [(np.float32, 1e-4), (np.float64, 1e-12)])
@given(seed=st.integers(0, 1000), gamma=st.floats(1e-3, 3.0), inputs=st.integers(1, 80))
@settings(max_examples=30)
def test_kernel_equals_that_of_scikit_learn(kind, close, seed, gamma, inputs):
    rng = np.random.default_rng(seed)
    vectors, x = rng.normal(size=(20, inputs)).astype(kind), rng.normal(size=(7, inputs))
    kernel = RbfKernel(vectors, gamma)
    values = kernel.rows(x.astype(kind))
    assert values.dtype == kind
    assert values.shape == (7, len(kernel))
    np.testing.assert_allclose(values, rbf_kernel(x, vectors, gamma), atol=close)


@pytest.mark.parametrize("sign", [-1, 1])
def test_overflowing_vector_is_not_treated_as_distant(sign):
    kernel = RbfKernel(np.full((2, 3), sign * 1e308), 0.1)
    with np.errstate(all="ignore"):
        assert np.isnan(kernel.rows(np.ones((4, 3)))).all()
