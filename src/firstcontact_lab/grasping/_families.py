"""Families of similar objects. Settings for judging an object are never tuned on its family."""

from __future__ import annotations

from collections.abc import Sequence

#: Families by words of the objects' names. An object without a family is a family by itself.
FAMILIES = (
    ("raspberry", "blueberry", "strawberry"),
    ("silken tofu", "bread roll"),
    ("peach", "tomato", "banana"),
    ("avocado",),
    ("paper cup", "mug", "wine glass"),
    ("sponge", "foam brick"),
    ("cloth", "stuffed toy"),
    ("orange", "apple"),
    ("quail egg", "hen egg"),
    ("potato crisp", "cracker"),
    ("soup can", "mustard bottle", "sugar box"),
    ("hammer", "wrench", "screwdriver"),
    ("wood block", "Rubik's cube"),
)


def family(kind: str) -> str:
    """Return the family that an object belongs to."""
    for words in FAMILIES:
        if any(word in kind for word in words):
            return " and ".join(words)
    return kind


def folds(kinds: Sequence[str], count: int) -> dict[str, int]:
    """Return the fold of each object. All objects of a family are in one fold."""
    families = list(dict.fromkeys(family(kind) for kind in kinds))
    return {str(kind): families.index(family(kind)) % count for kind in kinds}
