"""Network on disk: arrays in safetensors, and a JSON card with their checksum.

They lie beside the detector that goes with them, and beside models of fixed windows.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from importlib.resources import files
from pathlib import Path
from typing import Annotated, Any

import msgspec

from firstcontact.core import (
    Count,
    InputError,
    Name,
    Notes,
    Rate,
    Sha256,
    digest,
    read_card,
    read_weights,
    replacing,
    write_weights,
)
from firstcontact.models._compact import CompactModel
from firstcontact.models._in_context import InContextModel
from firstcontact.models._learned_from import Digests, read_digests, to_bytes

FORMAT = "firstcontact-anytime-model"
#: Raised whenever older files can no longer be read.
FORMAT_VERSION = 1
CARD = "anytime.json"
WEIGHTS = "anytime.safetensors"
#: Digests of the pinches that the rig is known by.
PINCHES = "anytime-pinches.bin"


@dataclass(frozen=True, slots=True, kw_only=True)
class AnytimeCard:
    """Card of the network.

    Parameters
    ----------
    kind
        Of the model.
    rate_hz
        Sampling rate that it takes, Hz.
    level
        Share that its intervals are to hold.
    sha256
        Of the weights.
    pinches, levels
        What the rig is known by: how many pinches, and of which Shore A.
    contacts
        How their contacts were found, in words.
    source, sessions, specimens
        Of these pinches, each once.
    pinches_sha256
        Of the file with their digests; None where there is none.
    trained
        On what the network was trained, in words.
    scores, size
        Of the training, for people: nothing is computed from them.
    versions
        Of the libraries.
    """

    kind: Name
    rate_hz: Rate
    level: Annotated[float, msgspec.Meta(gt=0, lt=1)]
    sha256: Sha256
    pinches: Count = 0
    levels: tuple[float, ...] = ()
    contacts: Notes = ""
    source: Name = ""
    sessions: tuple[Name, ...] = ()
    specimens: tuple[Name, ...] = ()
    pinches_sha256: Sha256 | None = None
    trained: Notes = ""
    scores: Mapping[Name, Any] = field(default_factory=dict)
    size: Mapping[Name, Any] = field(default_factory=dict)
    versions: Mapping[Name, Name] = field(default_factory=dict)


def save_anytime(
    model: InContextModel,
    directory: Path,
    about: Mapping[str, Any],
    digests: Digests | None = None,
) -> Path:
    """Write a model into a folder.

    Parameters
    ----------
    model
        The network.
    directory
        Made if it does not exist; a network in it is replaced.
    about
        Further fields of :class:`AnytimeCard`.
    digests
        Of the pinches that the rig is known by; None for a model that knows none.

    Raises
    ------
    InputError
        A card that could not be read again.
    """
    tree = {
        "format": FORMAT,
        "format_version": FORMAT_VERSION,
        "kind": model.kind,
        "rate_hz": model.rate,
        "level": model.level,
        **about,
    }
    file = directory / PINCHES
    if digests is not None:
        raw = to_bytes(digests)
        tree["pinches_sha256"] = digest(raw)
        with replacing(file) as temporary:
            temporary.write_bytes(raw)
    else:
        file.unlink(missing_ok=True)
    write_weights(directory / CARD, directory / WEIGHTS, tree, model.to_arrays(), AnytimeCard)
    return directory


def load_network_digests(directory: Path) -> Digests | None:
    """Digests of the pinches that a model's rig is known by; None where it does not say.

    Raises
    ------
    InputError
        A file that is missing or damaged.
    """
    vouched = read_anytime_card(directory).pinches_sha256
    return None if vouched is None else read_digests(directory / PINCHES, vouched, CARD)


def has_anytime(directory: Path) -> bool:
    """Return True if a folder holds a network."""
    return (directory / CARD).is_file()


def load_anytime(directory: Path) -> InContextModel:
    """Read the network of a folder. Nothing in it is executed.

    Raises
    ------
    InputError
        A file that is missing, damaged, of another program or version, or whose numbers do not
        fit together.
    """
    file = directory / CARD
    card = read_anytime_card(directory)
    kinds = {kind.kind: kind for kind in (InContextModel, CompactModel)}
    kinds["in_context"] = InContextModel  # its name in older cards
    if card.kind not in kinds:
        raise InputError(f"{file}: no network is of kind {card.kind!r}: update firstcontact")
    arrays = read_weights(directory / WEIGHTS, card.sha256, CARD)
    try:
        return kinds[card.kind].from_arrays(arrays, card.level)
    except InputError as error:
        raise InputError(
            f"{directory / WEIGHTS}: {error}: make it again with `firstcontact adapt`"
        ) from None


def read_anytime_card(directory: Path) -> AnytimeCard:
    """Read the card of a folder's network; InputError if it is damaged."""
    return read_card(directory / CARD, "network", FORMAT, FORMAT_VERSION, AnytimeCard)


def pretrained() -> InContextModel:
    """The model that came with the package: it knows no rig yet.

    Raises
    ------
    InputError
        A package that is damaged.
    """
    return load_anytime(pretrained_folder())


def pretrained_folder() -> Path:
    """Return the folder of the pre-trained network."""
    return Path(str(files("firstcontact.models"))) / "pretrained"
