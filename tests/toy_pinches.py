"""Synthetic pinches: noise, then a damped oscillation that is faster on harder objects."""

import numpy as np

from firstcontact.core import (
    Channel,
    ChannelKind,
    Contact,
    Dataset,
    Finger,
    Label,
    Layout,
    Pinch,
    Role,
)

RATE = 4936.0
CONTACT = 500
LAYOUT = Layout(
    tuple(Channel(f"piezo_{f.name}", ChannelKind.VIBRATION, f, "V") for f in Finger), RATE
)


def pinch(
    label: Label, seed: int, hardness: float, has_contacts: bool = True, second: int = 90
) -> Pinch:
    """Return one pinch. The other finger touches ``second`` samples after the first contact."""
    rng = np.random.default_rng(seed)
    data = 0.002 * rng.standard_normal((900, 2))
    finger = Finger(seed % 2)
    for f, start in ((finger, CONTACT), (finger.other, CONTACT + second)):
        t = np.arange(len(data) - start) / RATE
        ring = np.sin(2 * np.pi * (60 + 4 * hardness) * t) * np.exp(-t / 0.010)
        data[start:, f] += (0.1 + 0.005 * hardness) * rng.uniform(0.8, 1.2) * ring
    truth = (
        (
            Contact(finger, CONTACT, CONTACT),
            Contact(finger.other, CONTACT + second, CONTACT + second),
        )
        if has_contacts
        else ()
    )
    return Pinch(data.astype(np.float32), LAYOUT, label, truth=truth)


def shore_dataset(
    each: int = 12,
    levels: tuple[float, ...] = (10.0, 30.0, 60.0),
    objects: tuple[float, ...] = (20.0, 50.0),
    sessions: int = 3,
    has_contacts: bool = True,
) -> Dataset:
    """Return blocks in sessions, and unseen objects in a session of their own."""
    pinches = []
    for level in levels:
        for i in range(each):
            label = Label(f"block {level:g}", level, None, f"block {level:g}", f"s{i % sessions}")
            offset = 30 + 15 * (i % 6)
            pinches.append(pinch(label, len(pinches), level, has_contacts, offset))
    for shore in objects:
        for _ in range(each // 2):
            name = f"fruit {shore:g}"
            label = Label(name, shore, None, name, "unseen", Role.TEST)
            pinches.append(pinch(label, len(pinches), shore, has_contacts))
    return Dataset(tuple(pinches), "synthetic")


def rank_dataset(each: int = 6) -> Dataset:
    """Return materials with a rank and no other label, with one known contact each."""
    materials = {"mat": 0, "foam": 0, "box": 1, "wood": 1, "desk": 2, "stone": 2}
    pinches = []
    for n, (material, rank) in enumerate(materials.items()):
        for i in range(each):
            label = Label(material, None, rank, material, f"s{i % 2}")
            p = pinch(label, len(pinches), 20.0 * rank + 3 * n)
            pinches.append(Pinch(p.data, p.layout, label, 0, p.truth[:1]))
    return Dataset(tuple(pinches), "real")
