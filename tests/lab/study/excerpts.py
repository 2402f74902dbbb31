"""Short pinches of the twin and subjects of a study, for tests of its parts."""

from firstcontact.core import Contact, Dataset, Label, Pinch
from firstcontact.twin import CONDITIONS, draw_pinch, simulate_pinch
from firstcontact.twin.pinch import excerpt
from firstcontact_lab.study.part import Subject


def twin_pinches(kinds, each: int, sessions: int) -> list[Pinch]:
    out = []
    for kind in kinds:
        for number in range(each):
            session = f"{kind.role} {number % sessions}"
            label = Label(kind.name, kind.shore_a, None, kind.name, session, kind.role)
            draw = draw_pinch(7, CONDITIONS["paper-rig"], session, kind, f"{kind.name} {number}")
            out.append(simulate_pinch(excerpt(draw, 0.045), label, duration=0.07))
    return out


def subject(pinches: list[Pinch], late: int = 2, decided: int = 8) -> Subject:
    contacts = tuple(
        p.first and Contact(p.first.finger, p.first.sample + late, p.first.sample + decided)
        for p in pinches
    )
    return Subject("any", Dataset(tuple(pinches)), contacts)
