"""Families of similar household objects, and folds of families.

Settings that are scored on an object were tuned without the object's whole family.
"""

from __future__ import annotations

from collections.abc import Sequence

#: Words for each family: an object whose name has one of them belongs to it. An object without such
#: a word is a family by itself.
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
    """Return the family of an object. A family can consist of a single object."""
    for words in FAMILIES:
        if any(word in kind for word in words):
            return " and ".join(words)
    return kind


def folds(kinds: Sequence[str], count: int) -> dict[str, int]:
    """Return the index of the fold of each object. All objects of a family are in one fold."""
    families = list(dict.fromkeys(family(kind) for kind in kinds))
    return {str(kind): families.index(family(kind)) % count for kind in kinds}
