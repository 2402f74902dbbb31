"""Measure which signals the any-time model marks as out of range, and write the table of them.

    python docs/write_out_of_range.py             write the table from docs/results
    python docs/write_out_of_range.py --measure   measure simulated rigs and made-up signals first
    python docs/write_out_of_range.py --measure --data FOLDER   also real strikes and impacts

``espeak-ng`` speaks the speech if it is installed. Rows that cannot be measured are left out.
Nothing of the model was chosen on these rigs and seeds.
"""

from __future__ import annotations

import argparse
import csv
import json
import shutil
import subprocess
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from numpy.typing import NDArray

from firstcontact.contact.finder import find_onsets
from firstcontact.core.layout import FINGERTIP_RATE
from firstcontact.models import Touches
from firstcontact.models.model_file import pretrained
from firstcontact.models.rig.rig_model import RigModel
from firstcontact.models.rig.rigs import Rig
from firstcontact.signal import resample, samples_in
from firstcontact_lab.report.tables import fill, markdown_table

RESULTS = Path(__file__).parent / "results" / "out_of_range.json"
PAGE = Path(__file__).parent / "reference" / "lab-notes.md"
#: Times after the contact, ms.
TIMES = (3, 5, 15)
#: Number of signals of each made-up kind, number of rigs of each family, and random seed.
SIGNALS, RIGS, SEED = 400, 30, 97
#: Number of the first rig. No other program of this project uses these rigs.
FIRST_RIG = 9_000_000
WORDS = (
    "Take the paper cup. Put it down gently, but do not drop it. Touch a block, an apple, a tennis "
    "ball and a soft orange. Stop before the door closes. Keep your fingers open until I count to "
    "ten: one, two, three, four, five, six, seven, eight, nine, ten."
)
Signal = NDArray[np.float64]
_BEFORE, _AFTER = (
    samples_in(Touches.BEFORE, FINGERTIP_RATE),
    samples_in(Touches.LONGEST, FINGERTIP_RATE),
)
_TIME = np.arange(_AFTER) / FINGERTIP_RATE


def sine(frequency: float, least: float, most: float) -> Callable[[np.random.Generator], Signal]:
    """Return sines near a frequency, Hz, that decay in ``least`` to ``most`` seconds."""

    def made(rng: np.random.Generator) -> Signal:
        turns = 2 * np.pi * frequency * np.exp(0.05 * rng.standard_normal()) * _TIME
        phase = rng.uniform(0, 2 * np.pi) if np.isinf(least) else np.pi * rng.integers(0, 2)
        decay = np.exp(rng.uniform(np.log(least), np.log(most))) if np.isfinite(most) else np.inf
        return np.sin(turns + phase) * np.exp(-_TIME / decay)

    return made


def noise(rng: np.random.Generator) -> Signal:
    """Return white noise."""
    return rng.standard_normal(_AFTER) / 3


MADE_UP = {
    **{f"sine of {f} Hz": sine(f, np.inf, np.inf) for f in (60, 150, 300, 600, 1200, 2000)},
    **{
        f"sine of {f} Hz, damped in 3 to 30 ms": sine(f, 0.003, 0.03)
        for f in (100, 200, 400, 800, 1600)
    },
    "noise that begins": noise,
    "step": lambda rng: np.full(_AFTER, 1.0),
    "click of 0.3 ms": lambda rng: np.exp(-_TIME / 3e-4) * rng.choice([-1.0, 1.0]),
}


def made_up(make: Callable[[np.random.Generator], Signal]) -> Touches:
    """Return made-up signals as contacts. Noise of 0.2 to 5 % of the peak precedes each signal."""
    rng = np.random.default_rng([SEED, 1])
    quiet = np.exp(rng.uniform(np.log(0.002), np.log(0.05), (SIGNALS, 1)))
    signals = quiet * rng.standard_normal((SIGNALS, _BEFORE + _AFTER))
    signals[:, _BEFORE:] += [make(rng) for _ in range(SIGNALS)]
    return cut_touches(list(signals))


def cut_touches(signals: list[Signal]) -> Touches:
    """Return signals as contacts, with all samples valid."""
    n = len(signals)
    valid = np.full(n, _AFTER, np.intp)
    array = np.array(signals, np.float32).reshape(n, _BEFORE + _AFTER)
    return Touches.from_signals(array, valid, np.full(n, -1, np.intp), FINGERTIP_RATE)


def cut_contacts(
    sound: Signal, rate: float, onsets: list[float] | None, most: int = 10**6
) -> Touches:
    """Cut contacts from a sound at its onsets, s. Without onsets, detect at most ``most``."""
    x = resample(sound[:, None], rate, FINGERTIP_RATE)[:, 0]
    places = [round(s * FINGERTIP_RATE) for s in onsets or ()]
    if onsets is None:
        places = [o.sample for o in find_onsets(x[:, None], FINGERTIP_RATE)][:most]
    cut = [Touches.cut_signal(x[: place + _AFTER], place, FINGERTIP_RATE) for place in places]
    ends = [place + _AFTER <= len(x) for place in places]
    return cut_touches(
        [c for c, is_complete in zip(cut, ends, strict=True) if is_complete and c is not None]
    )


def read_wav(file: Path) -> tuple[int, Signal]:
    """Return the rate and the first channel of 16-bit sound, as shares of full scale."""
    from scipy.io import wavfile

    rate, data = wavfile.read(file)
    return rate, (data if data.ndim == 1 else data[:, 0]) / 32768.0


def strikes(folder: Path) -> Iterator[Touches]:
    """Yield the labelled strikes on piezo discs, file by file."""
    by_file: dict[str, list[int]] = {}
    with (folder / "hits.csv").open(encoding="utf-8") as stream:
        for row in csv.DictReader(stream):
            by_file.setdefault(row["file"], []).append(int(row["onset_sample"]))
    for file, onsets in by_file.items():
        rate, sound = read_wav(folder / "wav" / file)
        yield cut_contacts(sound, rate, [onset / rate for onset in onsets])


def impacts(folder: Path) -> Iterator[Touches]:
    """Yield the first onset of each recorded impact."""
    for file in sorted((folder / "wav").glob("*.wav")):
        rate, sound = read_wav(file)
        yield cut_contacts(sound, rate, None, 1)


def speech() -> Iterator[Touches]:
    """Yield the onsets in spoken words, voice by voice."""
    for voice in ("en-gb", "en-us", "de", "fr"):
        with TemporaryDirectory() as folder:
            file = Path(folder) / "spoken.wav"
            subprocess.run(["espeak-ng", "-v", voice, "-w", file, WORDS], check=True)
            rate, sound = read_wav(file)
        rng = np.random.default_rng([SEED, 2])
        sound = np.concatenate([np.zeros(rate // 5), sound])
        yield cut_contacts(sound + 1e-3 * rng.standard_normal(len(sound)), rate, None)


def joined(parts: Iterator[Touches]) -> Touches:
    """Return the contacts of several sounds as one set."""
    return cut_touches([signal for part in parts for signal in part.signals])


def count_out_of_range(model: RigModel, touches: Touches) -> NDArray[np.float64]:
    """Return the number of contacts out of range at each of ``TIMES``."""
    longest = [samples_in(1e-3 * ms, touches.rate) for ms in TIMES]
    return np.array(
        [model.predict_touches(touches.until(n)).out_of_range.sum() for n in longest], float
    )


def simulated(family: str, rigs: int) -> list[tuple[Rig, Touches]]:
    """Return random rigs, each conditioned on its block pinches, with contacts to judge."""
    from firstcontact_lab.pretraining.batches import cut
    from firstcontact_lab.pretraining.examples import MARGIN, placing, rig_examples, volts

    made = []
    for number in range(rigs):
        examples = rig_examples(FIRST_RIG + number, SEED, family)
        level, sign = examples.scale[0, 0]
        tokens = examples.tokens[0, 0, :, : examples.levels[0, 0]]
        rig = Rig(level, sign, None, None, tokens, examples.general[0, 0])
        signals = volts(examples.signals)
        late = placing(np.random.default_rng([SEED, number]), np.zeros(len(signals), np.bool_))
        lead = signals[:, MARGIN : MARGIN + _BEFORE]
        segment = np.concatenate([lead, cut(signals, late)], axis=1)
        made.append((rig, cut_touches(list(segment))))
    return made


def measured(data: Path | None) -> dict[str, Any]:
    """Return all rows: signals, and their share out of range per time with and without a rig."""
    from firstcontact_lab.rigs import FAMILIES

    unknown = pretrained()
    rows: dict[str, Any] = {}

    def add(group: str, name: str, n: int, with_rig: Signal, none: Signal) -> None:
        row = {"n": n, "rig": (with_rig / n).tolist(), "no_rig": (none / n).tolist()}
        rows.setdefault(group, {})[name] = row
        print(group, name, row)

    families = {"": "random rigs, as trained on"} | {k: f.title for k, f in FAMILIES.items()}
    rigs = []
    for family, title in families.items():
        made = simulated(family, RIGS if not family else RIGS // 3)
        rigs = rigs or [rig for rig, _ in made]
        rig_shares = sum(
            count_out_of_range(unknown.conditioned_on({Rig.ANY: rig}), touches)
            for rig, touches in made
        )
        none = sum(count_out_of_range(unknown, touches) for _, touches in made)
        add("touches", title, sum(len(touches) for _, touches in made), rig_shares, none)
    kinds: dict[str, Touches] = {}
    if data is not None:
        kinds["strikes on drum pads (real)"] = joined(strikes(data / "piezo_strikes"))
        kinds["marble on household surfaces (real)"] = joined(impacts(data / "impact_hardness"))
    if shutil.which("espeak-ng"):
        kinds["speech (synthetic)"] = joined(speech())
    kinds |= {name: made_up(make) for name, make in MADE_UP.items()}
    for name, touches in kinds.items():
        rig_shares = np.zeros(len(TIMES))
        rng = np.random.default_rng([SEED, 3])
        place = rng.integers(0, len(rigs), len(touches))
        peak = np.abs(touches.waves).max(axis=1)
        for number, rig in enumerate(rigs):
            members = np.flatnonzero(place == number)
            if len(members):
                # The signals are as loud as the rig's own contacts, within a factor of three.
                loud = rig.level * np.exp(rng.uniform(-np.log(3), np.log(3), len(members)))
                sample = touches.take(members)
                gain = (loud / peak[members])[:, None].astype(np.float32)
                scaled = replace(sample, signals=gain * sample.signals)
                rig_shares += count_out_of_range(unknown.conditioned_on({Rig.ANY: rig}), scaled)
        add("others", name, len(touches), rig_shares, count_out_of_range(unknown, touches))
    return rows


def table(rows: dict[str, Any]) -> str:
    """Return the rows as Markdown."""
    head = ["", "n", *(f"{ms} ms" for ms in TIMES)]
    lines = []
    for group, title in (
        ("touches", "**Touches of simulated rigs** (false)"),
        ("others", "**Other signals** (found)"),
    ):
        lines.append([title, *[""] * (len(head) - 1)])
        for name, row in rows[group].items():
            cells = [f"{100 * share:.1f} %" for share in row["rig"]]
            lines.append([name, str(row["n"]), *cells])
    return markdown_table(" | ".join(head), lines)


def filled(text: str) -> str:
    """Return the page with its table in place."""
    rows = json.loads(RESULTS.read_text(encoding="utf-8"))
    return fill(text, "signals", {"out_of_range": table(rows)})


def main() -> None:
    """Measure if requested, and write the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--measure", action="store_true", help="measure before the table is made")
    parser.add_argument("--data", type=Path, help="folder of piezo_strikes and impact_hardness")
    options = parser.parse_args()
    if options.measure:
        rows = measured(options.data)
        RESULTS.write_text(json.dumps(rows, indent=1) + "\n", encoding="utf-8")
    PAGE.write_text(filled(PAGE.read_text(encoding="utf-8")), encoding="utf-8")


if __name__ == "__main__":
    main()
