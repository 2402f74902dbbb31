"""Check of a kind of source, such as that of a plug-in."""

from __future__ import annotations

import time
from contextlib import suppress
from itertools import pairwise

import numpy as np

from firstcontact.core import InputError
from firstcontact.device import Arrival, Source, SourceKind
from firstcontact.device.opening import SourceOptions
from firstcontact.testing.synthetic import passes_exceptions

_OPTIONS = SourceOptions()
_WORD = "a marker of check_source"


def check_source(
    kind: SourceKind, device: str, options: SourceOptions = _OPTIONS, patience: float = 60.0
) -> None:
    """Assert that a kind of source behaves as required, on one of its devices.

    Each sample comes once, in order and with the layout in ``source.descriptor``. The source counts
    lost samples. It returns a marker with the samples, or refuses it if the source is a recording.
    The source can be closed at any time, and twice. It then returns the samples left, and ends.

    Parameters
    ----------
    kind
        Kind of source.
    device
        Name of the device as a user types it. The check opens the device more than once.
    options
        Options that a user gives with the device, such as the speed.
    patience
        Longest time to wait for samples, s.

    Raises
    ------
    AssertionError
        A check failed (the message names it), or there was no sample to check.
    InputError
        The device cannot be opened.
    """
    assert kind.accepts(device), f"{kind.name} does not take {device!r}"
    assert kind.title.strip(), f"{kind.name} has no title for help"
    kind.make(device, options).close()
    source = kind.make(device, options)
    passes_exceptions(source, "source")
    assert not source.health.connected, "an exception does not close the source"
    source = kind.make(device, options)
    with source:
        arrivals = _first_arrivals(source, patience)
        count = sum(len(a.block.data) for a in arrivals)
        assert count, f"{source.name} gave no sample within {patience:g} s: nothing was checked"
        arrivals += _arrivals_with_marker(kind, source, patience)
        source.close()
    source.close()
    arrivals += _remaining_arrivals(source, patience)
    _check_arrivals(source, arrivals)


def _first_arrivals(source: Source, patience: float) -> list[Arrival]:
    """Return the samples of the first 0.1 s from a source, or all if there are fewer."""
    layout = source.descriptor.layout
    assert not layout.why_unusable, f"the source's layout has {layout.why_unusable}"
    arrivals: list[Arrival] = []
    until = time.monotonic() + patience
    while not source.ended and time.monotonic() < until:
        arrivals += source.read(0.1)
        if sum(len(a.block.data) for a in arrivals) > 0.1 * layout.rate:
            break
    return arrivals


def _arrivals_with_marker(kind: SourceKind, source: Source, patience: float) -> list[Arrival]:
    """Send a marker to a source. Return the arrivals up to the one that contains the marker.

    Return [] for a recording, after checking that it refuses the marker.
    """
    if kind.is_replay:
        for tell in (source.mark, source.order):
            with suppress(InputError):
                tell(_WORD)
                raise AssertionError(
                    "a source that replays a recording accepts a marker or an order: it must "
                    "refuse both"
                )
        return []
    source.mark(_WORD)
    arrivals: list[Arrival] = []
    until = time.monotonic() + patience
    while time.monotonic() < until:
        arrivals += source.read(0.1)
        if any(m.text == _WORD for a in arrivals for m in a.markers):
            return arrivals
    raise AssertionError(f"the marker did not come within {patience:g} s")


def _remaining_arrivals(source: Source, patience: float) -> list[Arrival]:
    """Return the arrivals that can still be read from a source after it was closed."""
    arrivals: list[Arrival] = []
    until = time.monotonic() + patience
    with suppress(InputError):  # a closed source refuses to be read again once it gave nothing
        while not source.ended and time.monotonic() < until:
            arrivals += source.read(0.1)
    assert source.ended, f"the source has not ended {patience:g} s after closing"
    assert not source.read(0.0), "the source gives samples after its end"
    return arrivals


def _check_arrivals(source: Source, arrivals: list[Arrival]) -> None:
    descriptor, health = source.descriptor, source.health
    columns = descriptor.layout.width
    missing = 0
    for arrival in arrivals:
        data = arrival.block.data
        assert data.ndim == 2, f"a block has the shape {data.shape}: (samples, channels)"
        assert data.shape[1] == columns, f"a block has {data.shape[1]} of {columns} channels"
        assert data.dtype == descriptor.dtype, f"samples are {data.dtype}, not {descriptor.dtype}"
        assert np.isfinite(data).all(), "a sample is not finite"
        assert all(m.epoch == arrival.block.epoch for m in arrival.markers), (
            "a marker has the wrong epoch"
        )
    for previous, following in pairwise(arrivals):
        previous_block, block = previous.block, following.block
        assert following.host >= previous.host, "a block arrived before its predecessor"
        assert block.epoch >= previous_block.epoch, "the epoch decreases"
        if block.epoch == previous_block.epoch:
            assert block.first_sample >= previous_block.end, (
                f"sample {block.first_sample} comes twice"
            )
            missing += block.first_sample - previous_block.end
    count = sum(len(a.block.data) for a in arrivals)
    assert health.samples == count, f"the source counts {health.samples} samples and gave {count}"
    assert health.lost_samples >= missing, f"{missing} are missing, {health.lost_samples} counted"
    assert not health.connected, "the source is closed but reports a connection"
