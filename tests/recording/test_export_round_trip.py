"""Exported recordings of every kind come back equal, or the export is refused."""

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from import_files import as_hdf5
from scipy.io import savemat

import firstcontact as fc
from firstcontact import import_recordings
from firstcontact.core import (
    Channel,
    ChannelKind,
    Contact,
    Dataset,
    Finger,
    InputError,
    Label,
    Layout,
    Pinch,
    fingertip_layout,
)
from firstcontact.recording import EXPORTERS, Header, export, load_dataset, write_dataset
from firstcontact.recording.dataset import pause_between
from firstcontact.recording.settings import LAYOUT

VIBRATION, FORCE = ChannelKind.VIBRATION, ChannelKind.FORCE
SAMPLES = 60


def recorded(folder, channels, fingers, dtype="float32"):
    """Write a recording with one pinch for each finger that touches first, and load it."""
    layout = Layout(channels, 4936.0)
    rng = np.random.default_rng(len(channels))
    pinches = []
    for number, finger in enumerate(fingers):
        other = None if finger is None else finger.other
        truth = (Contact(finger, 20, 20), Contact(other, 30 + number, 30 + number))
        data = (512 + 20 * rng.normal(size=(SAMPLES, layout.width))).astype(dtype)
        pinches.append(Pinch(data, layout, Label("pear", session="s", specimen="p"), truth=truth))
    dataset = Dataset(pause_between(pinches), "real")
    folder.mkdir()
    write_dataset(dataset, folder, Header(layout, "real", dtype))
    return load_dataset(folder)


def matlab(folder, *rows):
    """Return an import of MATLAB variables that a table describes."""
    table = folder.with_suffix(".csv")
    table.write_text("\n".join(["variable,sensor,finger,rate_hz,unit,scale,offset", *rows]))
    rng = np.random.default_rng(0)
    savemat(
        folder.with_suffix(".mat"),
        {row.split(",")[0]: rng.integers(0, 4096, (SAMPLES, 1)).astype("u2") for row in rows},
    )
    import_recordings(folder.with_suffix(".mat"), folder, channels=table, source="real")
    return load_dataset(folder)


def twin(folder):
    return fc.simulate(folder, pinches_per_block=1, pinches_per_object=0, seed=5)[:2]


def sensor(finger, **changes):
    name = "disc" if finger is None else f"disc {finger.name}"
    return replace(Channel(name, VIBRATION, finger, "V"), **changes)


BOTH = (sensor(Finger.INDEX), sensor(Finger.THUMB))
EXTRAS = tuple(Channel(f"{c} {k}", FORCE, None, "N", 0.5, 7.0, k) for c in "ab" for k in range(6))
HAND = fingertip_layout().channels
RECORDINGS: dict[str, Callable[[Path], Dataset]] = {
    "twin": twin,
    "board": lambda f: recorded(f, (sensor(None, name="column a0", unit="counts"),), (None,)),
    "sound input": lambda f: recorded(f, (sensor(None, name="piezo", unit="full scale"),), (None,)),
    "thumb": lambda f: recorded(f, BOTH[1:], (Finger.THUMB,)),
    "thumb, index first": lambda f: recorded(f, BOTH[1:], (Finger.INDEX, Finger.THUMB)),
    "index of the hand, thumb first": lambda f: recorded(f, HAND[:1], tuple(Finger), "int16"),
    "one sensor, fingers known": lambda f: recorded(f, (sensor(None),), (*Finger, None)),
    "a finger unknown": lambda f: recorded(f, BOTH, (Finger.THUMB, None)),
    "three sensors": lambda f: recorded(f, (*BOTH, sensor(None)), (Finger.INDEX,)),
    "other order": lambda f: recorded(f, BOTH[::-1], tuple(Finger)),
    "one strip": lambda f: recorded(f, HAND[:15], tuple(Finger), "int16"),
    "other forces": lambda f: recorded(f, (*BOTH, *EXTRAS), tuple(Finger), "int32"),
    "long vectors": lambda f: recorded(f, (sensor(None, axes=5, axis=3),), (None,)),
    "two units": lambda f: recorded(f, (BOTH[0], replace(BOTH[1], unit="mV")), tuple(Finger)),
    "spaces": lambda f: recorded(f, (sensor(None, name=' a, "b" '),), (None,)),
    "time": lambda f: recorded(f, (sensor(None, name="time_s"),), (None,)),
    "label": lambda f: recorded(f, (*BOTH, Channel("role", FORCE, None, "N")), tuple(Finger)),
    "scaled": lambda f: matlab(f, "press,hydrophone,thumb,5000,mV,0.001,3"),
    "without a unit": lambda f: matlab(f, "x,piezo,,5000,,2,2000"),
    "counts": lambda f: matlab(f, "a,piezo,index,5000,counts,1,0", "b,piezo,thumb,5000,counts,2,9"),
    "beside": lambda f: matlab(f, "x,microphone,,5000,V,1,0", "temp,,index,5000,K,0.1,-2700"),
    "large offset": lambda f: matlab(f, "x,hydrophone,,5000,Pa,1e-6,-1e11"),
}
#: Recordings that a format cannot hold.
REFUSED = {
    "csv": {"two units", "large offset", "time", "label"},
    "hdf5": {"two units", "large offset", "three sensors", "one strip", "label", "beside"},
}


def physical(pinch):
    """Return the samples of each column in their unit."""
    layout = pinch.layout
    values = layout.physical(pinch.data, tuple(range(layout.width))).astype(np.float32)
    return dict(zip(layout.column_names, values.T, strict=True))


def check_equal(one, other):
    a, b = one.layout, other.layout
    assert a.rate == b.rate
    assert {replace(c, scale=1.0, offset=0.0) for c in a.channels} == set(b.channels)
    assert (one.source, one.sessions_assumed) == (other.source, other.sessions_assumed)
    for p, q in zip(one, other, strict=True):
        assert p.label == q.label
        assert [(c.finger, c.sample - p.first_sample) for c in p.truth] == [
            (c.finger, c.sample - q.first_sample) for c in q.truth
        ]
        for name, values in physical(p).items():
            assert np.array_equal(values, physical(q)[name])


@pytest.mark.parametrize("to", ["csv", "hdf5"])
@pytest.mark.parametrize("name", RECORDINGS)
def test_every_recording_comes_back_equal_or_is_refused(tmp_path, name, to):
    dataset = RECORDINGS[name](tmp_path / "in")
    path = tmp_path / f"x.{to}"
    if name in REFUSED[to]:
        with pytest.raises(InputError, match="export to"):
            export(dataset, EXPORTERS[to], path)
        return
    export(dataset, EXPORTERS[to], path)
    import_recordings(path, tmp_path / "out")
    check_equal(dataset, load_dataset(tmp_path / "out"))


def test_labels_of_an_exported_table_may_have_units(tmp_path):
    dataset = twin(tmp_path / "in")
    path = tmp_path / "x.csv"
    export(dataset, EXPORTERS["csv"], path)
    text = path.read_text(encoding="utf-8")
    path.write_text(text.replace("shore_a", "modulus (kPa)", 1), encoding="utf-8")
    import_recordings(path, tmp_path / "out")
    stated = [1e-3 * p.label.shore_a for p in dataset]
    assert [p.label.modulus_mpa for p in load_dataset(tmp_path / "out")] == pytest.approx(stated)


LAYOUT_OF_ONE = Layout((sensor(None),), 5000.0).to_json()


@pytest.mark.parametrize(
    "text",
    [
        "",
        "{}",
        json.dumps(LAYOUT_OF_ONE | {"rate": 100.0}),
        json.dumps(LAYOUT_OF_ONE | {"channels": []}),
        json.dumps(Layout(BOTH, 5000.0).to_json()),
    ],
)
def test_a_wrong_layout_is_refused(tmp_path, text):
    path = as_hdf5(tmp_path, np.zeros((1, SAMPLES, 1)), **{LAYOUT: text})
    with pytest.raises(InputError, match=rf"x\.h5.*{LAYOUT}"):
        import_recordings(path, tmp_path / "out")
    assert not (tmp_path / "out").exists()
