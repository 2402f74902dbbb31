"""The time ledger as lines of text, for the end of a run."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from firstcontact.core.percent import percent

#: Names in the ledger, and what they say.
_LINES = {
    "decide": "from a contact until it was noticed (device clock)",
    "window": "from a contact to its window's last sample (device clock)",
    "wait": "that sample's wait for the rest of its block (device clock)",
    "compute": "computing the estimate (this computer's clock)",
    "total": "from a contact to the estimate, in all",
    "first": "from a contact to the first answer",
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
        :meth:`firstcontact.live._ledger.Ledger.summary`.
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
        yield (f"times are left out: at --speed {speed:g} they say nothing of a hand in real time")
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


def _in_time(figures: Mapping[str, float], alone: bool) -> Iterator[str]:
    """What came before the second contact, where there can be one."""
    if "asked" in figures:
        answered = f"{figures['early']:.0f} of {figures['asked']:.0f} pinches had an answer"
        if not alone:
            answered += (
                " before the second finger touched, the time for computing it included; "
                f"{figures['standing']:.0f} had their final answer by then"
            )
        yield answered
    if not figures["estimates"] and "asked" in figures:
        return
    used = f"{figures['used']:.0f} of {figures['estimates']:.0f} estimates could be used"
    if alone:
        yield used
        return
    yield (
        f"models of a fixed window: {used}, because they came before the second finger's touch "
        f"was noticed; {figures['late']:.0f} of these came after the touch itself, which is "
        "noticed a little later: too late"
    )
