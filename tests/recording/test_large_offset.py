"""Small vibrations on a large offset: imports keep them, or are refused."""

import numpy as np
import pytest
from import_files import MAKERS, as_npz
from scipy.io import savemat

from firstcontact import import_recordings
from firstcontact.core import InputError

CHANNELS = "variable,sensor,finger,rate_hz\nx,piezo,index,5000\ny,piezo,thumb,5000\n"


def as_mat(folder, values):
    savemat(folder / "x.mat", {"x": values[0, :, :1], "y": values[0, :, 1:]})
    (folder / "channels.csv").write_text(CHANNELS)
    return folder / "x.mat"


def import_values(folder, make, values):
    channels = folder / "channels.csv" if make is as_mat else None
    return import_recordings(make(folder, values), folder / "out", channels=channels)


@pytest.mark.parametrize("make", [*MAKERS, as_mat])
@pytest.mark.parametrize("offset", [0.0, 1.0, 1e2, 1e6])
@pytest.mark.parametrize("column", [0, 1])
def test_vibrations_keep_a_thousandth_of_their_rms_or_are_refused(tmp_path, make, offset, column):
    values = np.random.default_rng(0).normal(0, 1e-3, (1, 1000, 2))
    values[..., column] += offset
    if offset > 30:
        with pytest.raises(InputError, match="offset"):
            import_values(tmp_path, make, values)
        assert not (tmp_path / "out").exists()
    else:
        (pinch,) = import_values(tmp_path, make, values)
        assert np.abs(pinch.vibration() - values[0]).max() < 1e-6


@pytest.mark.parametrize("make", [*MAKERS, as_mat])
def test_a_constant_column_is_not_refused(tmp_path, make):
    values = np.random.default_rng(0).normal(0, 1e-3, (1, 1000, 2))
    values[..., 1] = 1.65
    (pinch,) = import_values(tmp_path, make, values)
    assert np.ptp(pinch.vibration()[:, 1]) == 0


def test_the_offsets_of_pinches_count_apart(tmp_path):
    values = np.random.default_rng(0).normal(0, 1e-3, (2, 1000, 1))
    values += np.array([1000, -1000])[:, None, None]
    with pytest.raises(InputError, match="piezo"):
        import_values(tmp_path, as_npz, values)
