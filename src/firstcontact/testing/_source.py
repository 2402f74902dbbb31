"""What every source of samples keeps to."""

from __future__ import annotations

import time
from contextlib import suppress
from itertools import pairwise

import numpy as np

from firstcontact.core import InputError
from firstcontact.device import Arrival, Source, SourceKind, SourceOptions

_OPTIONS = SourceOptions()
_WORD = "a word of check_source"


def check_source(
    kind: SourceKind, device: str, options: SourceOptions = _OPTIONS, patience: float = 60.0
) -> None:
    """Hold a kind of sources against what its registry promises, on one of its devices.

    Samples come in order, each once, as the descriptor says, and what is missing is counted. A
    word is pinned to a sample, or refused where all has happened. It can be closed at any time and
    twice, and then ends.

    Parameters
    ----------
    kind
        What is registered.
    device
        As a person would name it. It is opened twice.
    options
        What else a person may say.
    patience
        Longest wait for samples, s.

    Raises
    ------
    AssertionError
        Says what it does otherwise; or it gave no sample to check.
    InputError
        The device cannot be opened.
    """
    assert kind.accepts(device), f"{kind.name} does not take {device!r}"
    assert kind.title.strip(), f"{kind.name} has no title for help"
    kind.make(device, options).close()
    _passes_exceptions(kind.make(device, options))
    source = kind.make(device, options)
    with source:
        arrivals = _given(source, patience)
        count = sum(len(a.block.data) for a in arrivals)
        assert count, f"{source.name} gave no sample within {patience:g} s: nothing was checked"
        arrivals += _marked(kind, source, patience)
        source.close()
    source.close()
    arrivals += _rest(source, patience)
    _hold(source, arrivals)


def _given(source: Source, patience: float) -> list[Arrival]:
    """At least a tenth of a second of samples, or all that there are."""
    layout = source.descriptor.layout
    assert not layout.fault, f"its layout has {layout.fault}"
    arrivals: list[Arrival] = []
    until = time.monotonic() + patience
    while not source.ended and time.monotonic() < until:
        arrivals += source.read(0.1)
        if sum(len(a.block.data) for a in arrivals) > 0.1 * layout.rate:
            break
    return arrivals


def _marked(kind: SourceKind, source: Source, patience: float) -> list[Arrival]:
    """What came until a word was pinned to a sample."""
    if kind.recorded:
        for tell in (source.mark, source.order):
            with suppress(InputError):
                tell(_WORD)
                raise AssertionError("what has happened already takes a word")
        return []
    source.mark(_WORD)
    arrivals: list[Arrival] = []
    until = time.monotonic() + patience
    while time.monotonic() < until:
        arrivals += source.read(0.1)
        if any(m.text == _WORD for a in arrivals for m in a.markers):
            return arrivals
    raise AssertionError(f"the word that was marked did not come within {patience:g} s")


def _rest(source: Source, patience: float) -> list[Arrival]:
    """What can still be read of a source that was closed."""
    arrivals: list[Arrival] = []
    until = time.monotonic() + patience
    while not source.ended and time.monotonic() < until:
        arrivals += source.read(0.1)
    assert source.ended, f"it was closed, and has not ended {patience:g} s later"
    assert not source.read(0.0), "it has ended, and gives more"
    return arrivals


def _hold(source: Source, arrivals: list[Arrival]) -> None:
    descriptor, health = source.descriptor, source.health
    columns = descriptor.layout.width
    missing = 0
    for arrival in arrivals:
        data = arrival.block.data
        assert data.ndim == 2, f"a block has the shape {data.shape}: (samples, channels)"
        assert data.shape[1] == columns, f"a block has {data.shape[1]} of {columns} channels"
        assert data.dtype == descriptor.dtype, f"samples are {data.dtype}, not {descriptor.dtype}"
        assert np.isfinite(data).all(), "a sample is not finite"
        assert all(m.epoch == arrival.block.epoch for m in arrival.markers), "a word's epoch is off"
    for before, after in pairwise(arrivals):
        one, other = before.block, after.block
        assert after.host >= before.host, "a block arrived before the one before it"
        assert other.epoch >= one.epoch, "an epoch comes again"
        if other.epoch == one.epoch:
            assert other.first_sample >= one.end, f"sample {other.first_sample} comes twice"
            missing += other.first_sample - one.end
    count = sum(len(a.block.data) for a in arrivals)
    assert health.samples == count, f"it counts {health.samples} samples and gave {count}"
    assert health.lost_samples >= missing, f"{missing} are missing, {health.lost_samples} counted"
    assert not health.connected, "it was closed, and says that it is connected"


def _passes_exceptions(source: Source) -> None:
    with suppress(ZeroDivisionError):
        with source:
            raise ZeroDivisionError
        raise AssertionError("an exception does not pass through its with block")
    assert not source.health.connected, "an exception does not close it"
