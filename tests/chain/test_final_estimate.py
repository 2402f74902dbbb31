"""Each contact gets exactly one final event, which no later event replaces."""

import numpy as np

from firstcontact.chain import EventKind, Flag
from random_chains import FLOOR, Stream, python_events, random_image


def touches(rng: np.random.Generator) -> Stream:
    """Return a closing whose second finger touches near the model's last moment; some have NaN."""
    data = 4 * rng.normal(0.0, FLOOR, (500, 2)).astype(np.float32)
    for at, finger in zip((300, 300 + rng.integers(40, 90)), rng.permutation(2), strict=True):
        data[at:, finger] += 0.3 * np.sin(0.2 * np.arange(500 - at))
    if rng.random() < 0.3:
        data[rng.integers(300, 400), 0] = np.nan
    return Stream([(0, 0, data)], 0, False, 1.0, (0.0, 0.1, np.nan))


def test_each_contact_has_one_final_event() -> None:
    rng, estimated = np.random.default_rng(8), 0
    for seed in range(4):
        image = random_image(seed)
        for _ in range(150):
            finals, used, first = 0, 0, -1
            for e in python_events(image, touches(rng)):
                if e.flags & Flag.FINAL:
                    finals, used = finals + 1, e.samples
                elif e.kind == EventKind.CONTACT_FOUND and e.flags & Flag.FIRST:
                    finals, used, first = 0, 0, e.sample
                elif e.kind == EventKind.CONTACT_FOUND and finals:
                    assert e.sample >= first + used  # so that the final estimate stands
                elif e.kind == EventKind.ESTIMATED:
                    assert not finals
                elif e.kind == EventKind.CONTACT_WITHDRAWN:
                    first = -1
                elif e.kind == EventKind.CLOSING_ENDED and first >= 0:
                    assert finals == 1
                    estimated += used > 0
                    first = -1
    assert estimated > 20
