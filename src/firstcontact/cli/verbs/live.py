"""Verb ``firstcontact live``: contacts and estimates from a source, as they happen."""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from firstcontact.cli.options import Condition, Option, choice, devices
from firstcontact.contact import SLIP_DETECTORS
from firstcontact.core import InputError, is_same_rate, kernels, require_modules
from firstcontact.device import SOURCES, open_source, source_kind
from firstcontact.grasp import HANDS, POLICIES, live_policies

if TYPE_CHECKING:
    from firstcontact.cli.stopping import Stop
    from firstcontact.contact import Detector
    from firstcontact.core import Calibration
    from firstcontact.device import Source
    from firstcontact.streaming import Grasping, LiveSession, Predictor, Sink


@dataclass(frozen=True)
class Live:
    """Show contacts and stiffness live: in the terminal, on a page, and for other programs."""

    device: Annotated[str, devices()]
    """Source of the samples."""
    model: Annotated[Path | None, Option(group="model")] = None
    """Folder of the model; by default the package's, or the twin's own."""
    estimator: Annotated[str | None, Option(group="model", advanced=True)] = None
    """Estimator of the model that predicts; by default the one it was trained for."""
    detector: Annotated[Path | None, Option(group="model", advanced=True)] = None
    """Folder of a detector to use in place of the model's."""
    calibration: Annotated[Path | None, Option(group="model", advanced=True)] = None
    """File of `calibrate`; by default the noise is measured first."""
    page: Annotated[bool, Option(group="output")] = False
    """Serve a page at the address that is printed."""
    port: Annotated[int, Option(group="output", advanced=True)] = 8765
    """TCP port of the page; 0 takes a free one."""
    address: Annotated[str, Option(group="output", advanced=True)] = "127.0.0.1"
    """Address at which the page is served; other machines need the token, too."""
    token: Annotated[str | None, Option(group="output", advanced=True)] = None
    """Token for viewers on other machines that may control the session; random by default."""
    json: Annotated[bool, Option(group="output")] = False
    """Write JSON lines to standard output instead of text."""
    lsl: Annotated[bool, Option(group="output", advanced=True)] = False
    """Send samples and events by LSL."""
    hand: Annotated[str | None, choice(HANDS, "hand")] = None
    """Hand that the command drives."""
    hand_port: Annotated[str | None, Option(group="hand", advanced=True)] = None
    """Serial port of the hand, or the port name of its simulation if it has one."""
    policy: Annotated[str, choice(live_policies(), "hand")] = POLICIES.default
    """Grasp policy."""
    shape: Annotated[str, Option(group="model", advanced=True)] = ""
    """Shape of the objects for the network: flat, or a radius in mm."""
    one_object: Annotated[bool, Option(group="model", advanced=True)] = False
    """Pool all pinches as one object until you press N."""
    slip: Annotated[str | None, choice(SLIP_DETECTORS, "hand", advanced=True)] = None
    """Slip detector for a policy with a reflex; not tested on real slips."""
    record: Annotated[bool, Option(group="output")] = False
    """Start to record as soon as the command starts."""
    recordings: Annotated[Path, Option(group="output", advanced=True)] = Path(
        "firstcontact-recordings"
    )
    """Folder for recordings."""
    speed: Annotated[float, Option(group="simulated hand", advanced=True)] = 1.0
    """Speed as a multiple of real time; for a recording, inf is as fast as possible."""
    condition: Condition = "paper-rig"
    """Condition of the simulated hand."""
    seed: Annotated[int, Option(group="simulated hand", advanced=True)] = 0
    """Random seed of the simulated hand."""
    objects: Annotated[str, Option(group="simulated hand")] = "paper"
    """Objects of the simulated hand: paper, household, or one name."""
    seconds: Annotated[float | None, Option(group="output", advanced=True)] = None
    """Stop after this time, s."""
    pinches: Annotated[int | None, Option(group="output", advanced=True)] = None
    """Stop after this number of pinches."""

    def run(self) -> None:
        """Run until Ctrl-C or a limit of time or pinches."""
        self._check()
        if self.page:
            require_modules("live", "websockets")
            import websockets.asyncio.server  # noqa: F401  # slow, so before samples come
        if self.lsl:
            require_modules("live", "pylsl")
        kernels()  # an error before the session, if they are missing
        from firstcontact.cli.live_models import (
            SHIPPED,
            device_model_line,
            device_noise,
            landmarks,
            who_predicts,
        )
        from firstcontact.cli.stopping import stopping
        from firstcontact.contact import general_detector, load_detector
        from firstcontact.core import read_calibration
        from firstcontact.device import skipped_model
        from firstcontact.models import load_model
        from firstcontact.streaming import default_model, live_predictor, live_session

        source: Source = open_source(
            self.device,
            speed=self.speed,
            condition=self.condition,
            seed=self.seed,
            objects=self.objects,
        )
        # Before the source opens, because the twin's model may have to be trained.
        separate = None if self.detector is None else load_detector(self.detector)
        model = default_model(source) if self.model is None else load_model(self.model, separate)
        given = None if self.calibration is None else read_calibration(self.calibration)
        with stopping() as stop, source:
            device = source.descriptor.predictor
            detector, predictor, labels_by_shore_a = separate, None, {}
            if model.folder is not None or device is None:
                detector = separate or model.own_detector
                # The detector decides which rates fit.
                model = replace(model, detector=detector)
                predictor, labels_by_shore_a = (
                    live_predictor(model, self.estimator),
                    landmarks(model),
                )
                if model.folder is None:
                    _say(SHIPPED)
                elif predictor is not None:
                    _say(who_predicts(model, predictor, self.estimator))
            source = _at_rate(source, detector, predictor)
            if device is not None:
                _say(device_model_line(device, self.model))
            if (models := source.descriptor.model_slot) is not None and models.fault:
                _say(skipped_model(models, device is not None))
            to_stdout = self._to_stdout(source)
            with live_session(
                source,
                detector or general_detector(source.descriptor.layout),
                predictor,
                lambda: given or device_noise(device) or self._measured(source),
                real_time=self.speed == 1.0,
                hand=self.hand,
                hand_port=self.hand_port,
                policy=self.policy,
                slip=self.slip,
                recordings=self.recordings,
                shape=self.shape,
            ) as (session, grasping):
                sinks = [to_stdout, *self._sinks(session, labels_by_shore_a)]
                self._follow(session, stop, sinks)
            self._end(session, grasping)

    def _follow(self, session: LiveSession, stop: Stop, sinks: Sequence[Sink]) -> None:
        """Pass events to the outputs until Ctrl-C or a limit. Print the statistics."""
        from firstcontact.cli.session_keys import session_keys

        if self.one_object:
            session.new_object()
        began, used = session.source.health.samples, time.process_time()
        if self.record:
            _say(f"recording {session.start_recording()}")
        stop.gently = True
        # A replay without a pace can wait, so that no line of it is dropped.
        patient = math.isinf(self.speed)
        with session_keys(session):
            session.run(sinks, self.seconds, self.pinches, lambda: stop.requested, patient)
        self._report(session, session.source, began, time.process_time() - used)

    def _end(self, session: LiveSession, grasping: Grasping | None) -> None:
        """Print the statistics of the hand. Raise InputError if an output failed."""
        from firstcontact.streaming import grasp_lines

        if grasping is not None:
            for line in grasp_lines(grasping, real_time=self.speed == 1.0):
                _say(line)
        if session.recording.failed:
            raise InputError(session.recording.failed)
        assert session.fanout is not None
        failed = [f"{name} ({why})" for name, why in session.fanout.failed.items()]
        if failed:
            raise InputError(f"these outputs failed: {', '.join(failed)}")

    def _check(self) -> None:
        from firstcontact.models import parse_radius
        from firstcontact.streaming import check_hand

        if self.seconds is not None and not self.seconds > 0:
            raise InputError(f"--seconds is {self.seconds:g}: give a time above 0, or leave it out")
        if self.pinches is not None and self.pinches < 1:
            raise InputError(f"--pinches is {self.pinches}: give 1 or more, or leave it out")
        if not self.speed > 0:
            raise InputError(f"--speed is {self.speed:g}: give a number above 0")
        parse_radius(self.shape)
        if not 0 <= self.port <= 65535:
            raise InputError(f"--port is {self.port}: give one from 0 to 65535")
        kind = source_kind(self.device)
        check_hand(
            self.hand,
            self.hand_port,
            None if self.hand is None and self.policy == POLICIES.default else self.policy,
            self.slip,
            device=kind.name,
            is_live=self.speed == 1.0 and not kind.recorded,
        )

    def _measured(self, source: Source) -> Calibration | None:
        """Return a recording's noise floors, or measure the noise floors of a live source."""
        from firstcontact.collect import rest_request
        from firstcontact.device import REST, measure_noise

        if source.recorded:
            return source.calibration  # without noise floors, each closing is an epoch
        request = rest_request(source.descriptor.layout)
        _say(f"measuring the noise floor, {REST:g} s: {request}")
        return measure_noise(source)

    def _sinks(self, session: LiveSession, landmarks: dict[str, float]) -> list[Sink]:
        sinks: list[Sink] = []
        if self.lsl:
            from firstcontact.streaming import LslSink

            sinks.append(LslSink())
        if self.page:
            from firstcontact.streaming import PageSink

            page = PageSink(self.address, self.port, self.token, session, landmarks)
            _say(f"page: {page.url}")
            if page.look_url is not None:
                _say(f"page without controls, to look only: {page.look_url}")
            sinks.append(page)
        return sinks

    def _to_stdout(self, source: Source) -> Sink:
        from firstcontact.streaming import JsonLinesSink, TextSink

        if self.json:
            return JsonLinesSink(sys.stdout)
        return TextSink(sys.stdout, _shore_a(source, self.device))

    def _report(self, session: LiveSession, source: Source, began: int, cpu: float) -> None:
        from firstcontact.device import clock_line
        from firstcontact.streaming import ledger_lines

        health = source.health
        layout = source.descriptor.layout
        seconds = (health.samples - began) / layout.rate
        figures = session.pipeline.ledger.summary()
        alone = len(layout.vibration_fingers) < 2
        for line in ledger_lines(figures, seconds, cpu, alone=alone, speed=self.speed):
            _say(line)
        _say(
            f"link: {health.samples} samples, {health.lost} lost, "
            f"{health.bad_frames} damaged frames, {health.reconnects} reconnects"
        )
        if health.lost_samples:
            _say(
                "link: lost samples leave gaps, also in a recording; a pinch with a gap ends at "
                "the gap"
            )
        if health.overflow_samples:
            _say(f"link: the device dropped {health.overflow_samples} of the lost samples")
        if health.unusable_samples:
            _say(f"link: of the lost samples {health.unusable}")
        if health.late_answers or health.unheard_samples:
            _say(
                f"hand: its model left out {health.late_answers} late predictions and missed "
                f"{health.unheard_samples} samples"
            )
        if drift := clock_line(health, layout.rate):
            _say(drift)
        assert session.fanout is not None
        for name, dropped in session.fanout.dropped.items():
            if dropped and name not in session.fanout.failed:
                _say(f"{name}: {dropped} updates were dropped because this output was too slow")


def _at_rate(source: Source, detector: Detector | None, predictor: Predictor | None) -> Source:
    """Resample a source if its rate differs from the detector's or the model's.

    Print both rates.
    """
    from firstcontact.device import ResampledSource

    stated = source.descriptor.layout.rate
    trained = None if detector is None else detector.rate
    rate = trained or (None if predictor is None else predictor.rate)
    if rate is None or stated == rate:
        return source
    # A trained detector takes its own rate only. Without one, a rate that differs by no more than
    # a clock's error counts as the same.
    if trained is None and is_same_rate(stated, rate):
        return source
    resampled = ResampledSource(source, rate)
    _say(
        f"{source.name} sends {stated:g} samples a second and the model takes {rate:g}: they are "
        "resampled, also in recordings"
    )
    return resampled


def _shore_a(source: Source, device: str) -> Callable[[str], float | None]:
    """Return a function that maps the name of a simulated object to its Shore A, or to None."""
    origin = source.descriptor.source
    kinds = [source_kind(device), *(SOURCES[name] for name in SOURCES.builtin_names)]
    object_shore_a = next(
        (k.shore_a for k in kinds if k.shore_a is not None and k.origin == origin), None
    )

    def shore_a(name: str) -> float | None:
        if object_shore_a is None:
            return None
        try:
            return object_shore_a(name)
        except InputError:  # an object of another version, or the twin's extra is missing
            return None

    shore_a("")  # load the table of objects now, not between samples
    return shore_a


def _say(line: str) -> None:
    """Print a line for a person to standard error."""
    print(line, file=sys.stderr, flush=True)
