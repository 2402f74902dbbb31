"""Choice of a hand for a live session: the checks of its options, and its opening."""

from __future__ import annotations

from contextlib import ExitStack
from dataclasses import dataclass

from firstcontact.contact import SLIP_DETECTORS, SlipDetector
from firstcontact.core import ArgumentError
from firstcontact.core.quantity import SHORE_A
from firstcontact.device import Source
from firstcontact.device.clock import TransportDelay
from firstcontact.grasp import HANDS, POLICIES, Hand, Policy, open_hand
from firstcontact.grasp.hand import Begins
from firstcontact.grasp.registry import find_hand, find_policy, live_policy, make_hand
from firstcontact.models.anytime import Predictor
from firstcontact.streaming.grasping import Grasping


@dataclass(frozen=True, slots=True)
class HandPlan:
    """Options of a live session for a hand, its policy and its slip detector; by default no hand.

    Attributes
    ----------
    hand, port
        Hand, or its name, and the port that it is connected to.
    policy
        Grasp policy, or its name; None means the default.
    slip
        Name of a slip detector; None for no slip detection.
    """

    hand: str | Hand | None = None
    port: str | None = None
    policy: str | type[Policy] | Policy | None = None
    slip: str | None = None

    def check(self, device: str, *, is_live: bool) -> None:
        """Raise InputError if these options do not fit together, or do not fit the source.

        ``device`` is the name of the source. ``is_live`` is True if its samples arrive in real
        time.
        """
        policy, port = self.policy, self.port
        if policy is not None:
            find_policy(policy)
        if self.slip is not None:
            _check_slip(self.slip, self.hand, find_policy(policy or POLICIES.default))
        if self.hand is None:
            if policy is not None or port is not None:
                noun, parameter = ("port", "hand_port") if policy is None else ("policy", "policy")
                raise ArgumentError(
                    f"the {noun} has no effect without a hand: name a hand, or leave the {noun} "
                    "out",
                    parameter=parameter,
                )
            return
        kind = find_hand(self.hand)
        if isinstance(kind, Hand) and port is not None:
            raise ArgumentError(
                "a hand that is given as an object has its own port: leave the port out",
                parameter="hand_port",
            )
        if kind.needs_live_samples(port) and not is_live:
            simulated = kind.simulated_port
            instead = "" if simulated is None else f", or hand_port={simulated!r}"
            raise ArgumentError(
                f"the hand {kind.name!r} moves, so it needs a source with live samples: use the "
                f"hand {HANDS.default!r}{instead} with a recording",
                parameter="hand",
            )
        if kind.of_source not in (None, device):
            raise ArgumentError(
                f"the hand {kind.name!r} works only with the source {kind.of_source!r}: use this "
                "source or another hand",
                parameter="hand",
            )
        if isinstance(kind, type) and kind.of_source is None:
            make_hand(kind, port)  # opens nothing: a missing package is reported now

    def open(
        self, stack: ExitStack, source: Source, predictor: Predictor | None, *, real_time: bool
    ) -> Grasping | None:
        """Open the hand. Return the handler that drives it, or None without a hand.

        ``stack`` closes the hand at its end.
        """
        if self.hand is None:
            return None
        policy = live_policy(self.policy or POLICIES.default)
        _check_quantity(policy, predictor)
        layout = source.descriptor.layout
        return Grasping(
            policy,
            stack.enter_context(open_hand(self.hand, self.port, source=source)),
            layout,
            # At another speed than real time, no delay can be known.
            transport=TransportDelay(layout.rate) if real_time else None,
            slip=None if self.slip is None else _slip_detector(self.slip),
        )


def _check_quantity(policy: Policy, predictor: Predictor | None) -> None:
    """Raise ArgumentError if the policy uses estimates, but the model does not predict Shore A."""
    if policy.deadline is not None and predictor and predictor.quantity is not SHORE_A:
        raise ArgumentError(
            f"{policy.name} uses estimates in Shore A, but the model predicts "
            f"{predictor.quantity.axis}: choose a policy without estimates, or another model",
            parameter="policy",
        )


def _check_slip(slip: str, hand: str | Hand | None, policy: type[Policy] | Policy) -> None:
    """Raise ArgumentError unless the hand closes on request and the policy reacts to slips."""
    SLIP_DETECTORS.find(slip)
    if hand is None or Begins.US not in find_hand(hand).begins:
        raise ArgumentError(
            "only a hand that closes on request can react to slips: name such a hand, or leave the "
            "slip detector out",
            parameter="slip",
        )
    if not policy.has_reflex():
        raise ArgumentError(
            f"the policy {policy.name} does not react to slips: leave the slip detector out, or "
            "name a policy with a slip reflex",
            parameter="slip",
        )


def _slip_detector(name: str) -> SlipDetector:
    kind = SLIP_DETECTORS.find(name)
    with SLIP_DETECTORS.convert_errors(name):
        return kind()
