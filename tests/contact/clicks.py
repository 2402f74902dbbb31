"""Pinches of the twin in which a gear clicks before the contact."""

from dataclasses import replace
from itertools import pairwise

import numpy as np

from firstcontact.chain import ChainEvent, EventKind
from firstcontact.contact import ThresholdDetector
from firstcontact.contact.contacts import contact_chain
from firstcontact.core import Block, Finger, Pinch, fingertip_layout
from firstcontact.twin import BLOCKS, CONDITIONS, draw_pinch, simulate_pinch
from firstcontact.twin.draw import draw_specimen

PAPER_RIG = CONDITIONS["paper-rig"]

LAYOUT = fingertip_layout()
#: Sample at which the click begins, and its counts divided by 32.
CLICK, PEAK = 320, (30, -22, 12, -6, 3)


def make_pinch(seed: int, *, click: bool, finger: Finger = Finger.INDEX) -> Pinch:
    """Return a pinch of the twin. With ``click``, a gear clicks before the contact."""
    draw = draw_pinch(seed, PAPER_RIG, "s", draw_specimen(seed, PAPER_RIG, BLOCKS[4], 0), 0)
    pinch = simulate_pinch(draw, replace(Pinch(np.zeros((1, 16)), LAYOUT).label), 5_000)
    data = pinch.data.copy()
    if click:
        column = LAYOUT.vibration_fingers.index(finger)
        data[CLICK : CLICK + len(PEAK), column] += 32 * np.array(PEAK, np.int16)
    return replace(pinch, data=data)


def listen(pinch: Pinch, edges: list[int]) -> list[ChainEvent]:
    """Return the contacts and withdrawals in a pinch."""
    chain = contact_chain(ThresholdDetector(8.0), pinch.layout)
    return [
        event
        for a, b in pairwise([0, *sorted(edges), len(pinch.data)])
        for event in chain.take(Block(pinch.data[a:b], pinch.first_sample + a))
        if event.kind in (EventKind.CONTACT_FOUND, EventKind.CONTACT_WITHDRAWN)
    ]
