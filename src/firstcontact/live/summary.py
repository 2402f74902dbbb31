"""The time ledger as lines of text, for the end of a run."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

#: Names in the ledger, and what they say.
_LINES = {
    "decide": "contact to its decision (device clock)",
    "window": "contact to the window's last sample (device clock)",
    "wait": "that sample to the end of its block (device clock)",
    "compute": "that block read to the estimate (host clock)",
    "total": "contact to the estimate",
    "first": "contact to the first answer",
    "answer": "a block read to its answers (host clock)",
    "signal": "signal in the answer that stands",
}


def ledger_lines(
    figures: Mapping[str, float], samples: float, cpu: float, *, alone: bool = False
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
    """
    lines = {name: words for name, words in _LINES.items() if f"{name}_p50" in figures}
    if lines:
        yield f"{'ms':>52} {'p50':>8} {'p99':>8} {'max':>8}"
        for name, words in lines.items():
            values = (1e3 * figures[f"{name}_{key}"] for key in ("p50", "p99", "max"))
            yield f"{words:>52} " + " ".join(f"{v:8.3f}" for v in values)
    if "delay" in figures:
        yield f"of each wait, {1e3 * figures['delay']:.3f} ms are the source's own filter"
    if "asked" in figures:
        answered = f"{figures['early']:.0f} of {figures['asked']:.0f} pinches had an answer"
        if not alone:
            answered += (
                " before the second contact, all delays counted; in "
                f"{figures['standing']:.0f} the one that stands"
            )
        yield answered
    if figures["estimates"] or "asked" not in figures:
        used = f"{figures['used']:.0f} of {figures['estimates']:.0f} estimates could be used"
        if not alone:
            used += (
                f", {figures['late']:.0f} of these too late in hindsight: the second contact had "
                "happened and was not decided yet"
            )
        yield used
    yield (
        f"{figures['estimates']:.0f} estimates in {samples:.1f} s of samples; "
        f"{figures['overruns']:.0f} of {figures['blocks']:.0f} blocks took longer than they last"
    )
    if samples > 0:
        yield f"processor time {100 * cpu / samples:.1f} % of one core"
