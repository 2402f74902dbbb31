"""Model folders on disk: a JSON card, a safetensors file with all arrays, and the detector.

A folder contains no code, and nothing in it is executed.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path

import msgspec

from firstcontact.contact.detector_file import DETECTOR_FORMAT, DETECTOR_WEIGHTS, card_digest
from firstcontact.core import InputError, ModelError
from firstcontact.core.files import AnyPath, displaced_folder, given_path, read_regular
from firstcontact.core.installation import load_compiled, require_extra
from firstcontact.core.quantity import QUANTITIES, Quantity
from firstcontact.core.records import read_record
from firstcontact.core.weights import (
    DETECTOR_CARD,
    LONGEST_CARD,
    digest,
    read_weights,
    write_weights,
)
from firstcontact.core.weights import read_card as read_checked
from firstcontact.models.anytime import AnytimeModel
from firstcontact.models.card import (
    AnytimeCard,
    Digests,
    ModelCard,
    TrainingData,
    WindowCard,
    from_array,
    to_array,
)
from firstcontact.models.registry import model_class
from firstcontact.models.rig.rig_model import RigModel
from firstcontact.models.values import Arrays
from firstcontact.models.windows.window_predictor import WindowPredictor
from firstcontact.signal import samples_in

FORMAT = "firstcontact-model"
#: Version of the format. It increases when older folders can no longer be read.
FORMAT_VERSION = 3
CARD = "model.json"
WEIGHTS = "weights.safetensors"
#: Array of the digests of the training pinches.
PINCHES = "pinches"


#: Predictor with an entry in the card.
SavedPredictor = WindowPredictor | AnytimeModel


@dataclass(frozen=True, slots=True, eq=False)
class SavedModel:
    """Content of a model folder without the detector: predictors, and what they were trained on."""

    predictors: tuple[SavedPredictor, ...]
    trained_on: TrainingData
    digests: Digests


def write_model(
    folder: Path, predictors: Sequence[SavedPredictor], trained_on: TrainingData, digests: Digests
) -> None:
    """Write the card (``model.json``) and the weights of predictors into a folder.

    Save the detector there before, because the card holds its hash. ``digests`` are the hashes of
    the training pinches.
    """
    card = ModelCard(
        trained_on=trained_on,
        predictors=tuple(predictor.card() for predictor in predictors),
        detector=card_digest(folder) if (folder / DETECTOR_CARD).exists() else None,
    )
    arrays = {
        f"{number}.{name}": array
        for number, predictor in enumerate(predictors)
        for name, array in predictor.to_arrays().items()
    }
    if len(digests):
        arrays[PINCHES] = to_array(digests)
    tree = {"format": FORMAT, "format_version": FORMAT_VERSION, **msgspec.to_builtins(card)}
    write_weights(folder / CARD, folder / WEIGHTS, tree, arrays, ModelCard)


def has_model(folder: Path) -> bool:
    return (folder / CARD).exists()


def read_model(folder: Path) -> SavedModel:
    """Return the predictors in a model folder. Raise ModelError if a file is missing or damaged."""
    card = read_card(folder)
    for part in card.predictors:
        if isinstance(part, WindowCard):
            try:
                require_extra(model_class(part.kind, of_windows=True))
            except InputError as error:
                raise ModelError(f"{folder / CARD} cannot be used, because {error}") from None
    _check_detector(folder, card)
    arrays = read_weights(folder / WEIGHTS, card.sha256 or "", CARD)
    try:
        digests = from_array(arrays.pop(PINCHES, None))
    except InputError as error:
        raise ModelError(f"{folder / WEIGHTS} cannot be used, because {error}") from None
    predictors = []
    for number, part in enumerate(card.predictors):
        start = f"{number}."
        selected = {n.removeprefix(start): a for n, a in arrays.items() if n.startswith(start)}
        quantity = QUANTITIES[card.trained_on.target]
        predictors.append(_predictor(folder, part, selected, quantity))
    return SavedModel(tuple(predictors), card.trained_on, digests)


def read_card(path: AnyPath) -> ModelCard:
    """Return the checked card of a model folder. Raise ModelError if it is missing or invalid."""
    folder = model_folder(path)
    if not has_model(folder) and (aside := displaced_folder(folder)) is not None:
        raise ModelError(
            f"a training was killed while it replaced the folder {folder}: rename {aside}, which "
            f"holds the former content, to {folder.name}, or train again"
        )
    return read_checked(folder / CARD, "model", FORMAT, FORMAT_VERSION, ModelCard)


def model_folder(path: AnyPath) -> Path:
    """Return the folder of a model. ``path`` is the folder, or the card (``model.json``) in it."""
    folder = given_path(path, "model")
    return folder.parent if folder.name == CARD else folder


def _predictor(
    folder: Path, part: WindowCard | AnytimeCard, arrays: Arrays, quantity: Quantity
) -> SavedPredictor:
    remedy = "train again"
    if not isinstance(part, WindowCard):
        load_compiled("firstcontact.chain._compiled")  # their error is none of the file
    try:
        if isinstance(part, WindowCard):
            return WindowPredictor.from_card(part, arrays, quantity)
        remedy = "make it again with `firstcontact adapt`"
        kind: type[AnytimeModel] = model_class(part.kind, of_windows=False)
        return kind.from_arrays(arrays, part.level).with_record(part.record)
    except KeyError as error:
        reason = f"the array '{error}' is missing"
    except InputError as error:
        reason = str(error)
    except (ValueError, TypeError, IndexError, ArithmeticError):
        reason = f"the arrays are not those of a model of kind {part.kind!r}"
    raise ModelError(f"{folder / WEIGHTS} and {CARD} cannot be used ({reason}): {remedy}")


def _check_detector(folder: Path, card: ModelCard) -> None:
    """Raise ModelError if the detector in the folder is not the one that the card names.

    A folder without a detector passes, and so does a card that names none.
    """
    file = folder / DETECTOR_CARD
    if card.detector is None or not file.exists():
        return
    try:
        card_bytes = read_regular(file, LONGEST_CARD)
    except OSError as error:
        raise ModelError(f"{file} cannot be read ({error.strerror}): check the file") from None
    if digest(card_bytes) != card.detector:
        raise ModelError(
            f"{file} is not the detector that {folder / CARD} was trained with: "
            "copy the whole folder again, or train again"
        )


def pretrained() -> RigModel:
    """Return the package's network, which is not adapted to a rig yet."""
    [predictor] = read_model(pretrained_folder()).predictors
    assert isinstance(predictor, RigModel)
    return predictor


def pretrained_folder() -> Path:
    """Return the folder in the package that holds the pre-trained network."""
    return Path(str(files("firstcontact.models.rig"))) / "pretrained"


@dataclass(frozen=True, slots=True)
class _Format:
    """Field of a card that states the format, to tell this package's cards from others."""

    format: str


def check_replaceable(out: Path, windows: Sequence[float], network: bool) -> bool:
    """Return True if the folder ``out`` exists and is not empty.

    Raise ModelError if it holds files of other programs, or predictors that a new model would not
    replace. The new model has ``windows`` of these lengths, s, and a ``network`` or not.
    """
    if not out.is_dir():
        return False
    for path in sorted(out.iterdir()):
        formats = {CARD: FORMAT, DETECTOR_CARD: DETECTOR_FORMAT}
        is_weights = path.name in (WEIGHTS, DETECTOR_WEIGHTS) and not path.is_dir()
        is_card = path.name in formats and _card_format(path) == formats[path.name]
        if not (is_weights or is_card):
            raise ModelError(
                f"{out} would be replaced, but it holds {path.name}, which is not part of a model: "
                "choose another folder, or move that file away"
            )
    if has_model(out):
        _check_made_again(out, windows, network)
    return any(out.iterdir())


def _check_made_again(out: Path, windows: Sequence[float], network: bool) -> None:
    try:
        parts = read_card(out).predictors
    except InputError:
        return  # damaged: nothing is lost
    former = [part for part in parts if isinstance(part, WindowCard)]
    lost = [p for p in former if p.samples not in [samples_in(s, p.rate_hz) for s in windows]]
    if len(former) == len(windows) == 1:
        lost = []  # one window replaces another
    if lost or (len(former) < len(parts) and not network):
        raise ModelError(
            f"the folder {out} holds a model that the new one would not replace: choose another "
            "folder, or remove the old model"
        )


def _card_format(path: Path) -> str | None:
    """Return the field ``format`` of a card; None if the file is not a readable card."""
    try:
        return read_record(read_regular(path, LONGEST_CARD), _Format, "", "", LONGEST_CARD).format
    except (InputError, OSError):
        return None
