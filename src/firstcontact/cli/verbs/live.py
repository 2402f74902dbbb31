"""Command ``firstcontact live``: contacts and estimates from a source, as they happen."""

from __future__ import annotations

import logging
import math
import sys
import time
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from firstcontact.cli.options import Condition, Option, choice, devices
from firstcontact.contact import SLIP_DETECTORS
from firstcontact.core import FileError, InputError
from firstcontact.core.installation import load_compiled
from firstcontact.device import open_source
from firstcontact.grasp import HANDS, POLICIES
from firstcontact.grasp.registry import live_policies
from firstcontact.streaming.outputs import OUTPUTS, OutputOptions, find_outputs, make_sinks

if TYPE_CHECKING:
    from firstcontact.core import Calibration
    from firstcontact.device import Source
    from firstcontact.streaming.session import LiveSession

_log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Live:
    """Show contacts and stiffness live: in the terminal, on a page, and for other programs."""

    device: Annotated[str, devices()]
    """Source of the samples."""
    model: Annotated[Path | None, Option(group="model")] = None
    """Folder of the model; by default the package's, or one for the twin."""
    estimator: Annotated[str | None, Option(group="model", advanced=True)] = None
    """Estimator in the model folder that predicts; by default the first."""
    detector: Annotated[Path | None, Option(group="model", advanced=True)] = None
    """Folder of a contact detector that replaces the model's detector."""
    calibration: Annotated[Path | None, Option(group="model", advanced=True)] = None
    """File that `calibrate` wrote; by default the noise is measured first."""
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
    """Send samples and events by LSL (Lab Streaming Layer)."""
    foxglove: Annotated[bool, Option(group="output", advanced=True)] = False
    """Serve samples, forces and events to Foxglove, and to any web page in a browser here."""
    foxglove_address: Annotated[str, Option(group="output", advanced=True)] = "127.0.0.1:8766"
    """Address and TCP port for Foxglove; port 0 takes a free one."""
    output: Annotated[tuple[str, ...], choice(OUTPUTS, "output", advanced=True)] = ()
    """Names of outputs, also those of plug-ins."""
    hand: Annotated[str | None, choice(HANDS, "hand")] = None
    """Hand that the command drives."""
    hand_port: Annotated[str | None, Option(group="hand", advanced=True)] = None
    """Serial port of the hand, or the port name of its simulation if it has one."""
    policy: Annotated[str, choice(live_policies(), "hand")] = POLICIES.default
    """Grasp policy: reaction of the hand to contacts, estimates and slips."""
    shape: Annotated[str, Option(group="model", advanced=True)] = ""
    """Shape where the finger touches, for the network: flat, or radius in mm."""
    one_object: Annotated[bool, Option(group="model", advanced=True)] = False
    """Average all pinches as one object, until you press N for a new one."""
    slip: Annotated[str | None, choice(SLIP_DETECTORS, "hand", advanced=True)] = None
    """Slip detector for a policy with a reflex; not tested on real slips."""
    record: Annotated[bool, Option(group="output")] = False
    """Record all samples from the start of the command."""
    recordings: Annotated[Path, Option(group="output", advanced=True)] = Path(
        "firstcontact-recordings"
    )
    """Folder for recordings."""
    speed: Annotated[float, Option(group="simulated hand", advanced=True)] = 1.0
    """Speed as a multiple of real time; for a recording, inf is as fast as possible."""
    condition: Condition = "paper-rig"
    """Variation between pinches, as in the paper's set-up or everyday use."""
    seed: Annotated[int, Option(group="simulated hand", advanced=True)] = 0
    """Random seed of the simulated hand."""
    objects: Annotated[str, Option(group="simulated hand")] = "paper"
    """Objects of the simulated hand: paper, household, or one object's name."""
    seconds: Annotated[float | None, Option(group="output", advanced=True)] = None
    """Stop after this time, s."""
    pinches: Annotated[int | None, Option(group="output", advanced=True)] = None
    """Stop after this number of pinches."""

    def run(self) -> None:
        self._check()
        flags = {"json": self.json, "lsl": self.lsl, "foxglove": self.foxglove, "page": self.page}
        outputs = find_outputs([*(name for name in flags if flags[name]), *self.output])
        load_compiled("firstcontact.chain._compiled")  # if missing, an error before the session
        from firstcontact.cli.session_keys import session_keys
        from firstcontact.cli.stopping import stop_on_signals
        from firstcontact.contact import load_detector
        from firstcontact.streaming.hand_plan import HandPlan
        from firstcontact.streaming.live_session import SessionPlan, live_session

        source = open_source(
            self.device,
            speed=self.speed,
            condition=self.condition,
            seed=self.seed,
            objects=self.objects,
        )
        has_policy = self.hand is not None or self.policy != POLICIES.default
        policy = self.policy if has_policy else None
        plan = SessionPlan(
            model=self.model,
            estimator=self.estimator,
            detector=None if self.detector is None else load_detector(self.detector),
            calibration=self.calibration,
            hand=HandPlan(self.hand, self.hand_port, policy, self.slip),
            recordings=self.recordings,
            shape=self.shape,
        )
        with (
            stop_on_signals() as stop,
            live_session(source, plan, measure=_measure, opens=True, notify=_say) as session,
        ):
            sinks = make_sinks(
                outputs,
                session,
                OutputOptions(self.address, self.port, self.token, self.foxglove_address),
            )
            if self.one_object:
                session.new_object()
            began, used = session.source.health.samples, time.process_time()
            if self.record:
                _say(f"recording {session.start_recording()}")
            stop.gently = True
            with session_keys(session):
                session.run(
                    sinks,
                    seconds=self.seconds,
                    pinches=self.pinches,
                    stopped=lambda: stop.requested,
                    # A replay without a pace can wait, so that no line of it is dropped.
                    patient=math.isinf(self.speed),
                )
            self._report(session, began, time.process_time() - used)
        if session.grasping is not None:  # with the release at its end
            for line in session.grasping.lines(real_time=self.speed == 1.0):
                _say(line)
        if session.recording.failed:
            raise FileError(session.recording.failed)
        if failed := [f"{name} ({why})" for name, why in session.fanout.failed.items()]:
            raise InputError(
                f"outputs failed: {', '.join(failed)}; correct the causes or leave them out"
            )

    def _check(self) -> None:
        from firstcontact.core.physics import parse_radius
        from firstcontact.streaming.live_session import check_limits

        check_limits(self.seconds, self.pinches)
        parse_radius(self.shape)

    def _report(self, session: LiveSession, began: int, cpu: float) -> None:
        from firstcontact.device.source import clock_line
        from firstcontact.streaming.ledger import detail_lines, ledger_lines

        health, layout = session.source.health, session.source.descriptor.layout
        seconds = (health.samples - began) / layout.rate
        figures = session.pipeline.ledger.summary()
        alone = len(layout.vibration_fingers) < 2
        for line in ledger_lines(figures, alone=alone, speed=self.speed):
            _say(line)
        for line in detail_lines(figures, seconds, cpu, speed=self.speed):
            _log.info(line)  # shown with --verbose
        _say(health.link)
        if health.lost_samples:
            _say("link: lost samples leave gaps, also in a recording; a gap ends its pinch")
        if health.overflow_samples:
            _say(f"link: the device dropped {health.overflow_samples} of the lost samples")
        if health.unusable_samples:
            _say(f"link: of the lost samples {health.unusable_text}")
        if health.late_answers or health.unheard_samples:
            _say(
                f"hand: its model left out {health.late_answers} late predictions and missed "
                f"{health.unheard_samples} samples"
            )
        if drift := clock_line(health, layout.rate):
            _say(drift)
        for name, dropped in session.fanout.dropped.items():
            if dropped and name not in session.fanout.failed:
                _say(f"{name}: {dropped} updates were dropped because this output was too slow")


def _measure(source: Source) -> Calibration:
    from firstcontact.collect.calibration import rest_request
    from firstcontact.device.noise_floor import REST, measure_noise

    _say(f"measuring the noise floor, {REST:g} s: {rest_request(source.descriptor.layout)}")
    return measure_noise(source)


def _say(line: str) -> None:
    print(line, file=sys.stderr, flush=True)
