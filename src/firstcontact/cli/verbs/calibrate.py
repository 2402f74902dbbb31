"""``firstcontact calibrate``."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from firstcontact.cli.choices import devices
from firstcontact.core import InputError

if TYPE_CHECKING:
    from firstcontact.collect import Weighing
    from firstcontact.core import Calibration, ForceCurve
    from firstcontact.device import Source


@dataclass(frozen=True)
class Calibrate:
    """Measure noise floors, taps and the Velostat curve of a pair of fingertips."""

    device: Annotated[str, devices(recorded=False)]
    """Where samples come from."""
    out: Path = Path("calibration.json")
    """File for the result; what is there is replaced."""
    seconds: float = 2.0
    """How much rest is measured, s."""
    patience: float = 10.0
    """How much longer to wait for that rest, s; then it is refused."""
    tap: bool = True
    """Ask for a tap on each fingertip; --no-tap where nobody can, as with the twin."""
    weights: Path | None = None
    """A CSV of known weights on one taxel, with the columns finger,newtons,volts."""
    weigh: tuple[float, ...] = ()
    """Ask for these weights one after the other, N, and measure their volts."""

    def run(self) -> None:
        """Measure, tell, and write the file."""
        from firstcontact.cli.stopping import stopping
        from firstcontact.collect import read_weights, tap_warnings
        from firstcontact.core import check_writable, write_calibration
        from firstcontact.device import open_source

        if not 0.1 <= self.seconds <= 3600 or not 0 <= self.patience <= 3600:
            raise InputError("--seconds must lie between 0.1 and 3600, --patience from 0 on")
        # What hands have done must not be lost at the end.
        check_writable(self.out)
        curves = _fit(read_weights(self.weights)) if self.weights is not None else ()
        with stopping(), open_source(self.device) as source:
            calibration = self._measure(source)
            if self.weigh:
                curves = _fit(_weigh(source, self.weigh))
        calibration = replace(calibration, force=tuple(curves))
        for sentence in tap_warnings(calibration):
            print(f"warning: {sentence}")
        for curve in calibration.force:
            print(
                f"{curve.finger.name.lower():6} leak {curve.leak:.3g} S, gain {curve.gain:.3g} S, "
                f"exponent {curve.exponent:.2f}, off by {curve.rms:.2f} N RMS"
            )
        write_calibration(calibration, self.out)
        print(f"calibration: {self.out}")

    def _measure(self, source: Source) -> Calibration:
        from firstcontact.cli.sensor_words import rest_request, rest_words, sensor_of, tap_words
        from firstcontact.collect import wait_for_tap
        from firstcontact.core import finger_name
        from firstcontact.device import measure_noise

        layout = source.descriptor.layout
        print(f"measuring {self.seconds:g} s of rest: {rest_request(layout)}", flush=True)
        calibration = measure_noise(source, self.seconds, self.patience)
        for measured in calibration.piezo:
            words = rest_words(measured, sensor_of(layout, measured))
            print(f"{finger_name(measured.finger):6} {words}")
        if self.tap:
            for finger in layout.vibration_fingers:
                what = "sensor" if finger is None else f"{finger_name(finger)}'s fingertip"
                print(f"tap the {what}", flush=True)
                calibration = wait_for_tap(source, calibration, finger)
                tapped = next(p for p in calibration.piezo if p.finger is finger)
                if tapped.tap is not None:
                    words = tap_words(tapped.tap, sensor_of(layout, tapped))
                    print(f"{finger_name(finger):6} {words}")
        return calibration


def _fit(weighings: Sequence[Weighing]) -> tuple[ForceCurve, ...]:
    from firstcontact.collect import fit_force

    fingers = sorted({w.finger for w in weighings})
    if not fingers:
        raise InputError("no weight is given: add a line for each, or leave --weights out")
    return tuple(fit_force([w for w in weighings if w.finger is f]) for f in fingers)


def _weigh(source: Source, newtons: Sequence[float]) -> list[Weighing]:
    """Ask for each weight on each finger, and measure a second of it."""
    from firstcontact.cli.guided import entered
    from firstcontact.collect import Weighing, loaded_volts
    from firstcontact.core import finger_name
    from firstcontact.device import LinkNews

    weighings = []
    link = LinkNews(source.health)
    fingers = source.descriptor.layout.vibration_fingers
    for finger in (f for f in fingers if f is not None):
        for force in newtons:
            print(
                f"put {force:g} N on one taxel of the {finger_name(finger)} and press Enter",
                flush=True,
            )
            while not entered():
                source.read(0.1)
                for line in link.lines(source.health):
                    print(line, flush=True)
            volts = loaded_volts(source, finger)
            print(f"{finger_name(finger):6} {force:g} N: {volts:.3f} V")
            weighings.append(Weighing(finger, force, volts))
    return weighings
