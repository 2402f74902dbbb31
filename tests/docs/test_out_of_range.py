"""Results of the script for out-of-range signals are reproduced."""

import json

import numpy as np
import pytest
import write_out_of_range as script

from firstcontact.models.model_file import pretrained


@pytest.mark.parametrize("name", ["sine of 300 Hz", "noise that begins", "step"])
def test_a_row_is_printed_as_written(name: str) -> None:
    row = json.loads(script.RESULTS.read_text(encoding="utf-8"))["others"][name]
    touches = script.made_up(script.MADE_UP[name])
    assert len(touches) == row["n"]
    computed = script.count_out_of_range(pretrained(), touches) / len(touches)
    np.testing.assert_allclose(computed, row["no_rig"], atol=0.01)


def test_touches_are_rarely_out_of_range_and_most_other_signals_are() -> None:
    rows = json.loads(script.RESULTS.read_text(encoding="utf-8"))
    for labelled_contacts in ("rig", "no_rig"):
        assert max(rows["touches"]["random rigs, as trained on"][labelled_contacts]) < 0.03
        remaining = [np.mean(row[labelled_contacts]) for row in rows["others"].values()]
        assert np.median(remaining) > 0.95
