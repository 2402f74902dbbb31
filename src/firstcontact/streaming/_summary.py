"""The time ledger as lines of text, for the end of a run."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from firstcontact.core import percent

#: Names in the ledger, and what they say.
_LINES = {
    "decide": "from a contact until it was noticed (device clock)",
    "window": "from a contact to its window's last sample (device clock)",
    "wait": "that sample's wait for the rest of its block (device clock)",
    "transport": "its block's delay beyond the least (this computer's clock)",
    "compute": "computing the estimate (this computer's clock)",
    "total": "from a contact until the estimate was available",
    "first": "from a contact until the first answer was available",
    "answer": "computing answers (this computer's clock)",
    "signal": "length of the signal in the final answer",
}


def ledger_lines(
    figures: Mapping[str, float],
    samples: float,
    cpu: float,
    *,
    alone: bool = False,
    speed: float = 1.0,
) -> Iterator[str]:
    """Times of a run.

    Parameters
    ----------
    figures
        :meth:`firstcontact.streaming._ledger.Ledger.summary`.
    samples
        Length of what was worked on, s of the device's time.
    cpu
        Processor time that the whole program took for it, s.
    alone
        Whether there is one sensor only, so that no second contact can come.
    speed
        Of the samples, times real time: with another than 1 no times are told, and not what was
        in time, since the computer does not become faster with the samples.
    """
    if speed == 1.0:
        yield from _times(figures)
        yield from _in_time(figures, alone)
    else:
        yield (
            f"times are left out, and what was in time: at --speed {speed:g} they say nothing of a "
            "hand in real time"
        )
        yield _answered(figures)
    yield (
        f"{samples:.1f} s of samples in {figures['blocks']:.0f} blocks, of which "
        f"{figures['overruns']:.0f} took longer to work on than they last"
    )
    if samples > 0:
        yield f"processor time {percent(cpu / samples)} of one core"


def _times(figures: Mapping[str, float]) -> Iterator[str]:
    lines = {name: words for name, words in _LINES.items() if f"{name}_p50" in figures}
    if lines:
        yield f"{'times in ms':>60} {'median':>8} {'99 %':>8} {'longest':>8}"
        for name, words in lines.items():
            values = (1e3 * figures[f"{name}_{key}"] for key in ("p50", "p99", "max"))
            yield f"{words:>60} " + " ".join(f"{v:8.3f}" for v in values)
    if "delay" in figures:
        yield f"of each wait, {1e3 * figures['delay']:.3f} ms are the source's own filter"


def _answered(figures: Mapping[str, float]) -> str:
    answered = figures["pinches"] - figures["none"]
    return f"{answered:.0f} of {figures['pinches']:.0f} pinches had an estimate"


def _in_time(figures: Mapping[str, float], alone: bool) -> Iterator[str]:
    """Count each pinch once; a single sensor hears no second contact."""
    if alone:
        yield _answered(figures)
        return
    yield (
        f"{figures['pinches']:.0f} pinches: {figures['in_time']:.0f} with an estimate in time, "
        f"{figures['too_late']:.0f} too late, {figures['none']:.0f} without an estimate"
    )
    unheard = (
        f"; in {figures['unheard']:.0f} of these pinches no second contact was heard"
        if figures["unheard"]
        else ""
    )
    yield (
        "in time: available before the second contact, with waiting, transport and computing "
        f"counted{unheard}"
    )
