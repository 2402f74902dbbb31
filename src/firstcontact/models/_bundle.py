"""Model of a rig: a contact detector, and what predicts stiffness after a contact.

This is what a model folder holds, and what ``train`` and ``adapt`` return.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import nan
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from firstcontact.contact import (
    Detector,
    card_digest,
    load_detector,
    pretrained_detector,
    save_detector,
)
from firstcontact.core import (
    DETECTOR_CARD,
    Contact,
    Dataset,
    InputError,
    is_same_rate,
    replacing_folder,
)
from firstcontact.models._alignment import found
from firstcontact.models._anytime_file import (
    AnytimeCard,
    has_anytime,
    load_anytime,
    load_network_digests,
    pretrained,
    read_anytime_card,
    save_anytime,
)
from firstcontact.models._card import Provenance
from firstcontact.models._in_context import InContextModel
from firstcontact.models._interval import Interval
from firstcontact.models._learned_from import Digests
from firstcontact.models._model import WindowModel
from firstcontact.models._model_file import (
    has_models,
    load_digests,
    load_window_model,
    model_folders,
    read_card,
    save_model,
)
from firstcontact.models._spec import Values
from firstcontact.models._touch_stream import STEP
from firstcontact.models._touches import LONGEST, SHORTEST, touches_of
from firstcontact.models._train_folder import check_replaceable
from firstcontact.signal import contact_windows, resample_dataset, samples_in

#: Elapsed times after a contact at which the network predicts, s.
MOMENTS = tuple(n / 1000 for n in range(round(SHORTEST / STEP), round(LONGEST / STEP) + 1))


@dataclass(frozen=True, slots=True, eq=False)
class Predictions:
    """Predicted stiffness with interval, one per pinch; NaN without a prediction.

    Parameters
    ----------
    value
        Shore A, a hardness rank, or the class, shape (n,).
    low, high
        Ends of the interval in the same unit, shape (n,); equal to the value without an interval.
    out_of_range
        True where the contact is unlike all that the model was trained on, shape (n,).
    elapsed
        Length of the signal after the contact that was used, s, shape (n,).
    contacts
        First contact of each pinch, None where there is none.

    Examples
    --------
    >>> import firstcontact as fc
    >>> data = fc.load("recordings")
    >>> predictions: fc.Predictions = fc.adapt().predict(data[:2], at=0.003)
    >>> predictions.elapsed.round(3).tolist()
    [0.003, 0.003]
    """

    value: Values
    low: Values
    high: Values
    out_of_range: NDArray[np.bool_]
    elapsed: Values
    contacts: Sequence[Contact | None]

    def __len__(self) -> int:
        return len(self.value)


@dataclass(frozen=True, slots=True, eq=False)
class WindowPredictor:
    """Model of windows of one length, with its interval and its provenance.

    Parameters
    ----------
    model
        The window model.
    provenance
        Training data, held-out scores and interval.
    digests
        Of the training pinches; None where they are not known.
    name
        Folder of the model below that of the training; "" for the only one.
    """

    model: WindowModel
    provenance: Provenance
    digests: Digests | None = None
    name: str = ""

    @property
    def interval(self) -> Interval | None:
        """Interval around predictions, None without one."""
        return self.provenance.interval

    @property
    def duration(self) -> float:
        """Length of the window, s: the roundest one that has this number of samples."""
        spec = self.model.spec
        for decimals in (3, 4):
            length = round(spec.duration, decimals)
            if samples_in(length, spec.rate) == spec.samples:
                return length
        return spec.duration


@dataclass(frozen=True, slots=True, eq=False)
class NetworkPredictor:
    """Pre-trained network conditioned on a rig, with its provenance.

    Parameters
    ----------
    model
        The network.
    about
        Fields of the card that describe the rig's pinches.
    digests
        Of these pinches; None for an unknown rig.
    """

    model: InContextModel
    about: Mapping[str, Any] = field(default_factory=dict)
    digests: Digests | None = None

    @property
    def source(self) -> str:
        """Source of the rig's pinches; "" for an unknown rig."""
        return str(self.about.get("source", ""))

    @property
    def sessions(self) -> tuple[str, ...]:
        """Sessions of the rig's pinches."""
        return tuple(self.about.get("sessions", ()))

    @property
    def specimens(self) -> tuple[str, ...]:
        """Specimens of the rig's pinches."""
        return tuple(self.about.get("specimens", ()))


@dataclass(frozen=True, slots=True, eq=False)
class Model:
    """Contact detector and stiffness predictors of one rig.

    Parameters
    ----------
    detector
        Fitted contact detector; None where its file is missing from the folder.
    windows
        Window models, the shortest window first.
    network
        Network conditioned on the rig; None without one.
    notes
        Sentences about the training: held-out scores, and what was left out.
    detector_data
        Data that the detector was fitted to, for its card.
    folder
        Folder that the model was loaded from; None for one that was just trained.

    Examples
    --------
    >>> import firstcontact as fc
    >>> data = fc.load("recordings")
    >>> model = fc.adapt()
    >>> predictions = model.predict(data[:3], at=0.005)
    >>> len(predictions), bool((predictions.low < predictions.high).all())
    (3, True)
    """

    detector: Detector | None
    windows: tuple[WindowPredictor, ...] = ()
    network: NetworkPredictor | None = None
    notes: tuple[str, ...] = ()
    detector_data: Mapping[str, Any] = field(default_factory=dict)
    folder: Path | None = None

    def __repr__(self) -> str:
        parts = [f"detector={None if self.detector is None else self.detector.name!r}"]
        parts += [f"{w.model.kind!r} at {1e3 * w.duration:.3g} ms" for w in self.windows]
        if self.network is not None:
            parts.append(f"{self.network.model.kind!r} from 2 to 15 ms")
        return f"Model({', '.join(parts)})"

    @property
    def rate(self) -> float:
        """Sampling rate of the signals that it takes, Hz."""
        if self.windows:
            return self.windows[0].model.spec.rate
        if self.network is None:
            raise InputError("model: it holds a detector only: train with an estimator")
        return self.network.model.rate

    @property
    def moments(self) -> tuple[float, ...]:
        """Elapsed times after a contact at which it predicts, s, ascending."""
        times = {window.duration for window in self.windows}
        if self.network is not None:
            times |= set(MOMENTS)
        return tuple(sorted(times))

    def predict(
        self,
        data: Dataset,
        at: float | None = None,
        contacts: Sequence[Contact | None] | None = None,
        *,
        estimator: str | None = None,
    ) -> Predictions:
        """Predict the stiffness of each pinch.

        The network predicts where the model has one, else the longest window that fits. The
        network uses no sample after a known second contact.

        Parameters
        ----------
        data
            Pinches; they are resampled to the model's rate where theirs differs.
        at
            Longest signal after the contact, s; the longest that the model takes by default.
            ``Predictions.elapsed`` is shorter where the second finger touched earlier.
        contacts
            First contact of each pinch at the rate of ``data``; detected by default.
        estimator
            Name of the predictor to use, such as "svm", as ``repr`` shows it.

        Raises
        ------
        InputError
            ``at`` is shorter than the first moment, or ``data`` has another kind of signal.
        """
        require_dataset(data)
        if contacts is not None and len(contacts) != len(data):
            raise InputError(
                f"{len(data)} pinches need as many, and {len(contacts)} are given: None for a "
                "pinch without one",
                parameter="contacts",
            )
        if estimator is not None:
            return self.only(estimator).predict(data, at, contacts)
        if not self.moments:
            raise InputError("it holds a detector only: train with an estimator", parameter="model")
        latest = self.moments[-1] if at is None else at
        first, last = self.moments[0], self.moments[-1]
        if not first - 1e-9 <= latest <= 1.0:
            raise InputError(
                f"the model predicts from {first:.3g} to {last:.3g} s after a contact, "
                f"and {latest:g} s is given",
                parameter="at",
            )
        if not is_same_rate(data.layout.rate, self.rate):
            if contacts is not None:
                raise InputError(
                    f"contacts: they count samples at {data.layout.rate:g} Hz and the model takes "
                    f"{self.rate:g} Hz: resample the pinches first"
                )
            data = resample_dataset(data, self.rate)
        firsts = found(data, self.own_detector).contacts if contacts is None else list(contacts)
        if self.network is not None and latest >= MOMENTS[0] - 1e-9:
            return self._by_network(self.network.model, data, firsts, latest)
        fitting = [w for w in self.windows if w.duration <= latest + 1e-9]
        return self._by_window(fitting[-1], data, firsts)

    def only(self, estimator: str) -> Model:
        """Return the model with the predictors of this estimator alone."""
        windows = tuple(w for w in self.windows if w.model.kind == estimator)
        network = self.network
        if network is not None and network.model.kind != estimator:
            network = None
        if not windows and network is None:
            kinds = [w.model.kind for w in self.windows]
            kinds += [] if self.network is None else [self.network.model.kind]
            raise InputError(
                f"{estimator!r} is none of {', '.join(kinds)}, which the model has",
                parameter="estimator",
            )
        return replace(self, windows=windows, network=network)

    def _by_network(
        self,
        model: InContextModel,
        data: Dataset,
        contacts: Sequence[Contact | None],
        at: float,
    ) -> Predictions:
        n = len(data)
        value, low, high, elapsed = (np.full(n, nan) for _ in range(4))
        strange = np.zeros(n, np.bool_)
        touches, rows = touches_of(data, contacts)
        touches = touches.until(samples_in(at, touches.rate))
        enough = touches.valid >= model.shortest
        touches, rows = touches.take(enough), rows[enough]
        if len(rows):
            answers = model.answers(touches)
            value[rows], low[rows], high[rows] = answers.values, answers.low, answers.high
            strange[rows] = answers.strange
            elapsed[rows] = touches.valid / touches.rate
        return Predictions(value, low, high, strange, elapsed, contacts)

    def _by_window(
        self, window: WindowPredictor, data: Dataset, contacts: Sequence[Contact | None]
    ) -> Predictions:
        n = len(data)
        value, low, high, elapsed = (np.full(n, nan) for _ in range(4))
        X, has_window = contact_windows(data, contacts, window.model.spec.duration)
        if len(X):
            values = window.model.predict(X)
            ends = values, values
            if window.interval is not None:
                spreads = window.model.spread(X)
                scales = np.ones(len(values)) if spreads is None else spreads
                pairs = [
                    window.interval.around(float(value), float(scale))
                    for value, scale in zip(values, scales, strict=True)
                ]
                ends = np.array([p[0] for p in pairs]), np.array([p[1] for p in pairs])
            value[has_window], low[has_window], high[has_window] = values, *ends
            elapsed[has_window] = window.duration
        return Predictions(value, low, high, np.zeros(n, np.bool_), elapsed, contacts)

    def save(self, folder: str | os.PathLike[str]) -> Path:
        """Write the model folder whole; a former training in it is replaced.

        Returns
        -------
        Path
            The folder.

        Raises
        ------
        InputError
            ``folder`` holds files that no training wrote, or cannot be written.
        """
        folder = Path(folder)
        names = [window.name for window in self.windows]
        check_replaceable(folder, names, anytime=self.network is not None)
        with replacing_folder(folder) as making:
            self.write(making)
        return folder

    def write(self, folder: Path) -> None:
        """Write the files of the model into an empty folder, as :meth:`save` does."""
        save_detector(self.own_detector, folder, self.detector_data)
        for window in self.windows:
            card = replace(window.provenance, detector=card_digest(folder))
            save_model(window.model, folder / window.name, card, window.digests)
        if self.network is not None:
            save_anytime(self.network.model, folder, self.network.about, self.network.digests)

    @property
    def own_detector(self) -> Detector:
        """Contact detector; InputError where the folder had none."""
        if self.detector is None:
            raise InputError(
                f"{self.folder}: there is no detector here: name a folder that `firstcontact "
                "train` wrote"
            )
        return self.detector


def load_model(path: str | os.PathLike[str], detector: Detector | None = None) -> Model:
    """Load the model folder that ``train`` or ``adapt`` wrote. Nothing in it is executed.

    Parameters
    ----------
    path
        The folder.
    detector
        Contact detector to use in place of the one in the folder.

    Raises
    ------
    InputError
        A file is missing, damaged, or of another program or version.

    Examples
    --------
    >>> import firstcontact as fc
    >>> folder = fc.adapt().save("general")
    >>> fc.load_model(folder)
    Model(detector='logistic', 'network' from 2 to 15 ms)
    """
    folder = Path(path)
    network = None
    if has_anytime(folder):
        card = read_anytime_card(folder)
        network = NetworkPredictor(load_anytime(folder), _about(card), load_network_digests(folder))
    alone = network is not None or (folder / DETECTOR_CARD).exists()
    folders = model_folders(folder) if has_models(folder) or not alone else []
    windows = [_window(f, "" if f == folder else f.name) for f in folders]
    windows.sort(key=lambda window: window.duration)
    if detector is None and any((place / DETECTOR_CARD).exists() for place in (folder, *folders)):
        detector = load_detector(folders[0] if folders else folder)
    return Model(detector, tuple(windows), network, folder=folder)


def require_dataset(data: object) -> None:
    """Refuse what is not a dataset, such as a path.

    Raises
    ------
    InputError
        Names the parameter and the function that loads one.
    """
    if not isinstance(data, Dataset):
        raise InputError(
            f"a Dataset is needed, not {type(data).__name__}: load(path) gives one",
            parameter="data",
        )


def shipped_model() -> Model:
    """Return the model of the package: trained on the twin, it knows no rig."""
    return Model(pretrained_detector(), (), NetworkPredictor(pretrained()))


def _window(folder: Path, name: str) -> WindowPredictor:
    card = read_card(folder)
    provenance = Provenance(
        card.data, card.split, card.scores, card.interval, card.calibration, card.detector
    )
    return WindowPredictor(load_window_model(folder), provenance, load_digests(folder), name)


def _about(card: AnytimeCard) -> dict[str, Any]:
    names = ("pinches", "levels", "contacts", "source", "sessions", "specimens", "scores")
    return {name: getattr(card, name) for name in names}
