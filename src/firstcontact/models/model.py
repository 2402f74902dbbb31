"""Model of a rig: a contact detector and predictors of stiffness.

A rig is a hand with its sensors. A model folder stores one model. :func:`firstcontact.train` and
:func:`firstcontact.adapt` make models.
"""

from __future__ import annotations

import logging
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, cast

import numpy as np

from firstcontact.contact import Detector, load_detector, save_detector
from firstcontact.contact.detector_file import pretrained_detector
from firstcontact.core import ArgumentError, Contact, Dataset, Layout, ModelError
from firstcontact.core.files import given_path, replacing_folder, written_elsewhere
from firstcontact.core.physics import is_same_rate
from firstcontact.core.units import STATE_UNIT, VOLTS
from firstcontact.core.weights import DETECTOR_CARD
from firstcontact.models.alignment import Contacts, at_known_contacts, detect_alignment
from firstcontact.models.anytime import AnytimeModel, Predictor, PredictorLadder
from firstcontact.models.card import Digests, Target, TrainingData
from firstcontact.models.model_file import (
    SavedPredictor,
    check_replaceable,
    has_model,
    model_folder,
    pretrained,
    read_model,
    write_model,
)
from firstcontact.models.predictions import Predictions
from firstcontact.models.rig.rig_model import RigModel
from firstcontact.models.windows.regressor import class_name
from firstcontact.models.windows.window_predictor import WindowPredictor
from firstcontact.signal import resample_dataset
from firstcontact.signal.resampling import resample_contacts, restore_contacts

_log = logging.getLogger("firstcontact.models")


@dataclass(frozen=True, slots=True, eq=False)
class Model:
    """Contact detector and stiffness predictors of one rig (a hand with its sensors).

    Parameters
    ----------
    detector
        Fitted contact detector; None if its file is missing from the folder.
    predictors
        Window models (fixed signal length), the shortest window first, and the package's network,
        adapted to the rig. The estimator of the first entry predicts by default.
    trained_on
        Description of the training data.
    digests
        Hashes of the training pinches, to recognise them in other data.
    notes
        Sentences about the training: scores on held-out pinches, and pinches left out.
    detector_data
        Description of the data that the detector was fitted to; :meth:`save` stores it.
    folder
        Folder that the model was loaded from; None for a model that was just trained.

    Examples
    --------
    >>> import firstcontact as fc
    >>> data = fc.load("recordings")
    >>> model = fc.adapt()
    >>> predictions = model.predict(data[:3], at=0.005)
    >>> len(predictions), bool((predictions.low < predictions.high).all())
    (3, True)
    """

    detector: Detector | None = None
    predictors: tuple[SavedPredictor, ...] = ()
    trained_on: TrainingData = field(default_factory=TrainingData)
    digests: Digests = field(default_factory=lambda: np.zeros(0, np.uint64))
    notes: tuple[str, ...] = ()
    detector_data: Mapping[str, Any] = field(default_factory=dict)
    folder: Path | None = None

    def __post_init__(self) -> None:
        is_kind = isinstance(self.detector, type)
        if self.detector is not None and (is_kind or not hasattr(self.detector, "chain_constants")):
            raise ArgumentError(
                f"the detector must be a fitted one, not {self.detector!r}: load one with "
                "firstcontact.contact.load_detector(path)",
                parameter="detector",
            )

    def __repr__(self) -> str:
        parts = [f"detector={None if self.detector is None else self.detector.name!r}"]
        for p in self.predictors:
            first, last = (f"{1e3 * p.prediction_times[k]:.3g}" for k in (0, -1))
            parts.append(
                f"{p.name!r} " + (f"from {first} to " if first != last else "at ") + f"{last} ms"
            )
        return f"Model({', '.join(parts)})"

    @property
    def windows(self) -> tuple[WindowPredictor, ...]:
        """Predictors that use a fixed length of signal after the contact, the shortest first."""
        return tuple(p for p in self.predictors if isinstance(p, WindowPredictor))

    @property
    def anytime(self) -> AnytimeModel | None:
        """Predictor for several times after a contact, such as the network; None without one."""
        return next((p for p in self.predictors if isinstance(p, AnytimeModel)), None)

    @property
    def network(self) -> RigModel | None:
        """The package's pre-trained network, adapted to your rig; None if the model lacks it."""
        return next((p for p in self.predictors if isinstance(p, RigModel)), None)

    @property
    def rate(self) -> float:
        """Sampling rate of the signals that the default predictor needs, Hz."""
        return self.default().rate

    @property
    def estimators(self) -> tuple[str, ...]:
        """Names of the estimators that made the predictors. The first one predicts by default."""
        return tuple(dict.fromkeys(p.name for p in self.predictors))

    @property
    def prediction_times(self) -> tuple[float, ...]:
        """Times after a contact at which the default estimator predicts, s, ascending."""
        return () if not self.predictors else self.default().prediction_times

    def default(self, estimator: str | None = None, rate: float | None = None) -> Predictor:
        """Return the predictor that recordings, live sessions and exports use.

        Window models of one estimator are one predictor, which uses the longest available window.

        Parameters
        ----------
        estimator
            Name of an estimator; by default the first of :attr:`estimators`.
        rate
            Sampling rate of the signals, Hz. By default, the predictor may need any rate.

        Raises
        ------
        InputError
            The model has no predictor, none of this estimator, or none for this rate.
        """
        self._require_predictor()
        chosen = self if estimator is None else self.only(estimator)
        fitting = [p for p in chosen.predictors if rate is None or is_same_rate(p.rate, rate)]
        if not fitting:
            raise ArgumentError(
                f"the detector needs samples at {rate:g} Hz, but no model in its folder does: "
                f"train both together, with `firstcontact train --rate {rate:g}` or another rate",
                parameter="model",
            )
        steps = [p for p in fitting if p.name == fitting[0].name]
        return steps[0] if len(steps) == 1 else PredictorLadder(steps)

    def predict(
        self,
        data: Dataset,
        at: float | None = None,
        contacts: Contacts | Sequence[Contact | None] = "detected",
        *,
        estimator: str | None = None,
    ) -> Predictions:
        """Predict the stiffness of each pinch.

        By default, the first of :attr:`estimators` predicts. The network uses the object's shape,
        if the label states one, as :func:`live` does. A window model uses the longest window that
        fits into ``at`` and ends before the second finger's contact. If no window fits, the
        prediction is NaN. No prediction uses samples after a second contact that ``data`` contain.

        Parameters
        ----------
        data
            Pinches. They are resampled if their sampling rate differs from the model's.
        at
            Longest signal after the contact to use, s; by default the longest that the model can
            use. ``Predictions.elapsed`` is shorter if the second finger touched earlier.
        contacts
            "detected": predictions start at contacts that the detector finds, as in live use.
            "known": they start at the contacts in ``data``, from strips or labels. Or a sequence
            with the first contact of each pinch (None without one), in the samples of ``data``.
        estimator
            Name of another estimator to use; :attr:`estimators` lists them.

        Returns
        -------
        Predictions
            One prediction per pinch, in the order of ``data``.

        Raises
        ------
        InputError
            ``at`` is out of range, ``contacts`` do not fit ``data``, or the model cannot predict.
        """
        require_dataset(data)
        is_foreign = self.is_foreign(data.layout)
        given = _given_contacts(contacts, data)
        predictor = self.default(estimator)
        first, last = predictor.prediction_times[0], predictor.prediction_times[-1]
        latest = last if at is None else at
        if not first - 1e-9 <= latest <= 1.0:
            raise ArgumentError(
                f"{latest:g} s is outside {first:.3g} to 1 s: give a time in this range (after "
                f"{last:.3g} s the prediction stays the same)",
                parameter="at",
            )
        resampled = resample_dataset(data, predictor.rate)
        firsts: Sequence[Contact | None]
        if given is None:
            firsts = detect_alignment(resampled, self.own_detector).contacts
            given = restore_contacts(firsts, data, predictor.rate)
        else:
            firsts = resample_contacts(given, data, predictor.rate)
        out = predictor.predict_pinches(resampled, firsts, latest)
        out = replace(out, out_of_range=out.out_of_range | (is_foreign & np.isfinite(out.value)))
        target = self.target_of(predictor)
        return replace(out, contacts=given, estimator=predictor.name, target=target)

    def target_of(self, predictor: Predictor) -> Target:
        """Return the name of the quantity that a predictor predicts, such as "shore_a"."""
        return cast(Target, predictor.quantity.name)

    def only(self, estimator: str) -> Model:
        """Return a copy of the model with only the predictors of this estimator.

        For a scikit-learn regressor, ``estimator`` is the name of its class, or ``PACKAGE:NAME``.
        "network" returns the network alone if the model averages it with a regression. Raise
        InputError if the model has no predictor of this estimator.
        """
        self._require_predictor()
        network, estimator = self.network, class_name(estimator)
        parts = () if network is None else (network.network_alone(),)
        predictors = tuple(p for p in self.predictors if p.name == estimator)
        predictors = predictors or tuple(p for p in parts if p.name == estimator)
        if not predictors:
            raise ArgumentError(
                f"the model has no {estimator!r}: choose {' or '.join(self.estimators)}",
                parameter="estimator",
            )
        return replace(self, predictors=predictors)

    def _require_predictor(self) -> None:
        if not self.predictors:
            raise ModelError("the model has a detector, but no predictor: train or adapt one")

    def is_foreign(self, layout: Layout) -> bool:
        """Return True if predictions for signals in this layout's unit must count as out of range.

        This is so if the package's network was trained on signals in another unit. A model that was
        trained on your pinches in another unit raises InputError instead.
        """
        known, unit = self.trained_on.unit, layout.vibration_unit
        if not known and self.trained_on.pinches and self.trained_on.source != "twin":
            # Boards and streams without forces gave their own numbers until models stated a unit.
            is_converted = any(c.scale != 1.0 and c.unit == VOLTS for c in layout.vibration)
            if is_converted and len(layout.channels) == len(layout.vibration):
                _log.warning(
                    "the model does not state the unit of its training, and these signals are "
                    "converted to V: train again from the recordings. Until then, all predictions "
                    "count as out of range"
                )
                return True
        if known in ("", unit):
            return False
        line = (
            f"the model needs signals in {known}, but these are in {unit}: {STATE_UNIT} "
            "(csv:PORT=mV or =12bits for a board), or make a model with train or adapt from "
            "recordings of this sensor"
        )
        if self.trained_on.pinches:
            raise ArgumentError(line, parameter="model")
        _log.warning("%s. Until then, all predictions count as out of range", line)
        return True

    def save(self, folder: str | os.PathLike[str]) -> Path:
        """Save the model to a folder, and return the folder's path.

        The folder is created, or replaced as a whole if it holds an older model.

        Raises
        ------
        InputError
            ``folder`` cannot be written, holds files of other programs, or holds a model with
            predictors that this model lacks.
        """
        folder = given_path(folder, "folder")
        windows = [window.duration for window in self.windows]
        check_replaceable(folder, windows, network=self.network is not None)
        with replacing_folder(folder) as making:
            self.write(making)
        return folder

    def write(self, folder: Path) -> None:
        """Write the files of the model into ``folder``, which must be empty.

        :meth:`save` calls this method. If the disk refuses a file, the files are written to a
        temporary folder instead, which the InputError names.
        """
        try:
            self._write(folder)
        except OSError as error:
            raise written_elsewhere(folder, error, self._write) from error

    def _write(self, folder: Path) -> None:
        if self.detector is not None:
            save_detector(self.detector, folder, self.detector_data)
        if self.predictors:
            write_model(folder, self.predictors, self.trained_on, self.digests)

    @property
    def own_detector(self) -> Detector:
        """Contact detector of the model. To read it from a model without one raises InputError."""
        if self.detector is None:
            raise ModelError(
                f"the folder {self.folder} has no detector: name a folder that `firstcontact "
                "train` wrote"
            )
        return self.detector


def _given_contacts(
    contacts: Contacts | Sequence[Contact | None], data: Dataset
) -> list[Contact | None] | None:
    """Return the first contact of each pinch as the argument ``contacts`` states them.

    Return None if ``contacts`` is "detected". Raise ArgumentError for a wrong number of contacts.
    """
    if isinstance(contacts, str):
        is_known = at_known_contacts(contacts, data)
        return [p.first for p in data.pinches] if is_known else None
    given = list(contacts)
    if len(given) != len(data):
        raise ArgumentError(
            f"{len(given)} contacts are given for {len(data)} pinches: give one for each pinch, "
            "None if it has no contact",
            parameter="contacts",
        )
    return given


def load_model(path: str | os.PathLike[str], detector: Detector | None = None) -> Model:
    """Load a model that :meth:`Model.save` wrote. Nothing in its files is executed.

    Parameters
    ----------
    path
        Folder of the model.
    detector
        Contact detector to use instead of the one in the folder.

    Raises
    ------
    InputError
        A file is missing, damaged, or from another program or version.

    Examples
    --------
    >>> import firstcontact as fc
    >>> folder = fc.adapt().save("general")
    >>> fc.load_model(folder)
    Model(detector='logistic', 'network' from 2 to 15 ms)
    """
    folder = model_folder(path)
    has_detector = (folder / DETECTOR_CARD).exists()
    saved = read_model(folder) if has_model(folder) or not has_detector else None
    if detector is None and has_detector:
        detector = load_detector(folder)
    if saved is None:
        return Model(detector, folder=folder)
    return Model(detector, saved.predictors, saved.trained_on, saved.digests, folder=folder)


def require_dataset(data: object) -> None:
    """Raise InputError if ``data`` is not a Dataset (but a path, for example), or has no pinch."""
    if not isinstance(data, Dataset):
        raise ArgumentError(
            f"the data must be a Dataset, not a {type(data).__name__}: make one with load(path)",
            parameter="data",
        )
    if not len(data):
        raise ArgumentError("the data hold no pinch: give at least one", parameter="data")


def shipped_model() -> Model:
    """Return the package's model, which was trained on the twin and is not adapted to a rig."""
    return Model(pretrained_detector(), (pretrained(),), TrainingData(unit=VOLTS))
