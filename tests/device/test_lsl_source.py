"""Tests of LSL streams: in another process, killed and restarted, and with false statements."""

import time
import uuid
from collections.abc import Callable, Sequence

import numpy as np
import pytest
from lsl_outlet import ask, sending

from firstcontact.core import InputError
from firstcontact.device import Arrival
from firstcontact.device.lsl_source import LslSource, from_name
from firstcontact.device.opening import SourceOptions
from processes import PATIENCE

pylsl = pytest.importorskip("pylsl")

RATE = 4936.0
#: Longest time until a stream that cannot be used is refused, s: one, and what a busy machine adds.
SOON = 15.0


@pytest.fixture(autouse=True)
def _in_haste(monkeypatch: pytest.MonkeyPatch) -> None:
    """Shorten the search for a second stream, because all streams are local."""
    monkeypatch.setattr("firstcontact.device.lsl_source.ANOTHER", 0.1)


@pytest.fixture
def name() -> str:
    return f"a test {uuid.uuid4().hex}"


def until(source: LslSource, samples: int, epoch: int = 0) -> list[Arrival]:
    arrivals: list[Arrival] = []
    while sum(len(a.block.data) for a in arrivals if a.block.epoch == epoch) < samples:
        arrivals += source.read(5.0)
    return arrivals


def counts_and_numbers(arrivals: list[Arrival]) -> tuple[np.ndarray, np.ndarray]:
    """Return the stream's own counts, and the sample numbers of the source."""
    values = np.concatenate([a.block.data[:, 0] for a in arrivals]).astype(np.float64)
    numbers = np.concatenate([np.arange(a.block.first_sample, a.block.end) for a in arrivals])
    return values, numbers


@pytest.mark.parametrize("jitter", [0.0, 2.0])
def test_jittering_stream_has_no_losses(name: str, jitter: float) -> None:
    with sending(name, jitter=jitter), LslSource(name, ("count",)) as source:
        arrivals = until(source, 4000)
    values, numbers = counts_and_numbers(arrivals)
    assert source.health.lost_samples == 0
    np.testing.assert_array_equal(np.diff(values), 1.0)
    np.testing.assert_array_equal(np.diff(numbers), 1)


def test_skipped_samples_are_lost_at_their_place(name: str) -> None:
    with sending(name) as outlet, LslSource(name, ("count",)) as source:
        arrivals = until(source, 1000)
        ask(outlet, "lose 37")
        arrivals += until(source, 3000)
    values, numbers = counts_and_numbers(arrivals)
    assert source.health.lost_samples == 37
    assert len(set(values - numbers)) == 1


def test_restarted_stream_is_another_epoch(name: str) -> None:
    with sending(name) as outlet, LslSource(name, ("count",)) as source:
        until(source, 500)
        outlet.kill()
        while source.health.connected:
            source.read(0.05)
        with sending(name):
            arrivals = until(source, 500, epoch=1)
            assert source.health.connected
            assert source.health.reconnects == 1
    values, numbers = counts_and_numbers([a for a in arrivals if a.block.epoch == 1])
    assert numbers[0] == 0
    np.testing.assert_array_equal(np.diff(values), 1.0)


def test_vibration_channel_is_found_by_type_and_resampled(name: str) -> None:
    with sending(name, rate=10_000.0), LslSource(name) as source:
        layout = source.descriptor.layout
        assert layout.column_names == ("disc",)
        assert (layout.rate, layout.channels[0].unit) == (4936.0, "V")
        assert 0 < source.descriptor.delay <= 0.0005
        values, _ = counts_and_numbers(until(source, 1000))
    assert np.abs(values[200:]).max() == pytest.approx(1.0, abs=0.01)


def test_unusable_streams_are_refused(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(InputError, match="lsl:NAME"):
        from_name("lsl:", SourceOptions())
    with sending(name), pytest.raises(InputError, match="count, disc"):
        LslSource(name, ("violin",)).__enter__()
    with sending(name, rate=100.0), pytest.raises(InputError, match=r"\b500\b"):
        LslSource(name).__enter__()
    with sending(name, rate=2e6), pytest.raises(InputError, match=r"1e\+06"):
        LslSource(name).__enter__()
    monkeypatch.setattr("firstcontact.device.lsl_source.PATIENCE", 0.2)
    with pytest.raises(InputError, match="nobody"):
        LslSource("nobody sends this").__enter__()


class Outlet:
    """LSL stream in this process. The test pushes its samples."""

    def __init__(
        self,
        name: str = "",
        rate: float = RATE,
        labels: Sequence[str] = ("disc",),
        sender: str = "",
    ) -> None:
        self.name = name or f"a test {uuid.uuid4().hex}"
        self.rate, width = rate, len(labels)
        info = pylsl.StreamInfo(
            self.name, "Vibration", width, rate, pylsl.cf_double64, sender or self.name
        )
        channels = info.desc().append_child("channels")
        for label in labels:
            channels.append_child("channel").append_child_value("label", label)
        self.outlet = pylsl.StreamOutlet(info)
        self._width, self._heard = width, False

    def push(self, values: np.ndarray, stamps: np.ndarray) -> None:
        self._heard = self._heard or self.outlet.wait_for_consumers(5.0)
        assert self._heard
        rows = np.repeat(np.asarray(values, float)[:, None], self._width, axis=1)
        self.outlet.push_chunk(rows.tolist(), stamps.tolist())

    def past(self, samples: int, rate: float | None = None) -> np.ndarray:
        """Return the time stamps of this number of samples, the last of them now."""
        return pylsl.local_clock() + np.arange(-samples, 0) / (rate or self.rate)


def until_refused(source: LslSource, send: Callable[[], None] = lambda: None) -> None:
    began = time.monotonic()
    while time.monotonic() - began < PATIENCE:
        send()
        source.read(0.01)


def read_all(source: LslSource, samples: int) -> list[Arrival]:
    """Read until enough samples were delivered or lost."""
    arrivals: list[Arrival] = []
    began = time.monotonic()
    while source.health.samples + source.health.lost_samples < samples:
        assert time.monotonic() - began < PATIENCE, source.health
        arrivals += source.read(0.05)
    return arrivals + source.read(0.0)


@pytest.mark.parametrize(("bad", "stamped"), [(1e39, False), (np.nan, False), (np.nan, True)])
def test_a_stream_without_a_usable_sample_is_refused(bad: float, stamped: bool) -> None:
    outlet = Outlet()
    with LslSource(outlet.name) as source:
        values = np.zeros(1000) if stamped else np.full(1000, bad)
        stamps = np.full(1000, bad) if stamped else outlet.past(1000)
        began = time.monotonic()
        with pytest.raises(InputError, match="lsl:"):
            until_refused(source, lambda: outlet.push(values[:25], stamps[:25]))
        assert time.monotonic() - began < SOON
        assert source.health.lost_samples > 100
        assert source.ended


@pytest.mark.parametrize("stated", [50_000.0, 2500.0])
@pytest.mark.parametrize("honest", [True, False])
def test_wrong_stated_rate_is_refused(stated: float, honest: bool) -> None:
    outlet = Outlet(rate=stated)
    true = 5000.0
    with LslSource(outlet.name) as source:
        began, zero, count = time.monotonic(), pylsl.local_clock(), 0

        def send() -> None:
            nonlocal count
            numbers = np.arange(count, int((pylsl.local_clock() - zero) * true))
            count += len(numbers)
            if len(numbers):
                # Stamps by the true rate, or by the stated one where a program makes them.
                outlet.push(np.sin(numbers / 9), zero + numbers / (true if honest else stated))

        with pytest.raises(InputError, match="rate"):
            until_refused(source, send)
        assert time.monotonic() - began < SOON


def test_ambiguous_stream_name_is_refused_with_the_choices(monkeypatch: pytest.MonkeyPatch) -> None:
    left = Outlet(sender="left")
    right = Outlet(left.name, sender="right")
    with monkeypatch.context() as patient:
        patient.setattr("firstcontact.device.lsl_source.ANOTHER", PATIENCE)
        with pytest.raises(InputError, match=f"lsl:{left.name}@left, lsl:{left.name}@right"):
            LslSource(left.name).__enter__()
    with LslSource(f"{left.name}@right") as source:
        right.push(np.zeros(100), right.past(100))
        assert read_all(source, 50)


def test_stream_name_is_not_evaluated_as_a_query(monkeypatch: pytest.MonkeyPatch) -> None:
    outlet = Outlet()
    quoted = Outlet(f'it\'s "one" {uuid.uuid4().hex}')
    with LslSource(quoted.name) as source:
        assert source.descriptor.sensor.startswith(quoted.name)
    monkeypatch.setattr("firstcontact.device.lsl_source.PATIENCE", 0.3)
    for name in (f"{outlet.name}' or name='x", f'{outlet.name}" or name="x', "x' or '1'='1"):
        with pytest.raises(InputError, match="LSL"):
            LslSource(name).__enter__()


@pytest.mark.parametrize(
    ("bad", "at"),
    [(np.nan, 0), (np.inf, 4935), (-np.inf, 1300), (1e300, 0), (1e9, 1300), (-1e9, 0), (3e4, 1300)],
)
def test_invalid_stamp_costs_its_sample(bad: float, at: int) -> None:
    outlet = Outlet()
    stamps = outlet.past(4936)
    stamps[at] = bad if not np.isfinite(bad) or abs(bad) > 1e8 else stamps[at] + bad
    values = np.arange(4936.0)
    with LslSource(outlet.name) as source:
        outlet.push(values, stamps)
        arrivals = read_all(source, len(values))
    np.testing.assert_array_equal(*counts_and_numbers(arrivals))
    assert source.health.lost_samples == source.health.unusable_samples == 1
    assert source.health.reconnects == 0


def test_clock_step_starts_an_epoch() -> None:
    outlet = Outlet()
    with LslSource(outlet.name) as source:
        stamps = outlet.past(4936)
        outlet.push(np.zeros(2468), stamps[:2468])
        read_all(source, 2468)
        outlet.push(np.zeros(2468), stamps[2468:] + 7200.0)
        read_all(source, 4936)
    assert source.health.reconnects == 1
    assert (source.health.samples, source.health.lost_samples) == (4936, 0)


@pytest.mark.parametrize("is_whole", [True, False])
def test_stamps_that_run_backwards_are_refused(is_whole: bool) -> None:
    outlet = Outlet()
    zero, count = pylsl.local_clock(), 0
    with LslSource(outlet.name) as source:

        def send() -> None:
            nonlocal count
            stamps = zero + np.arange(count, count + 50) / outlet.rate
            count += len(stamps)
            # All of them run backwards, or those of each chunk.
            outlet.push(np.zeros(50), 2 * zero - stamps if is_whole else stamps[::-1])

        with pytest.raises(InputError):  # on a busy machine, for its rate
            until_refused(source, send)


def test_jittering_stamps_do_not_run_backwards() -> None:
    outlet = Outlet()
    stamps = np.random.default_rng(0).permutation(outlet.past(2 * 4936))
    with LslSource(outlet.name) as source:
        outlet.push(np.zeros(len(stamps)), stamps)
        read_all(source, len(stamps))
