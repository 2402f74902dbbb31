"""Public functions that make, read and describe recordings."""

from __future__ import annotations

from collections.abc import Iterable
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from firstcontact.core import ArgumentError

if TYPE_CHECKING:
    from firstcontact.contact import Detector
    from firstcontact.core import Contact, Dataset, Pinch
    from firstcontact.core.display import Progress
    from firstcontact.core.files import AnyPath
    from firstcontact.models import Evaluation, Model, Predictions


def load(path: AnyPath | Iterable[AnyPath]) -> Dataset:
    """Load the pinches (closings of the hand) in recordings, with their labels.

    Parameters
    ----------
    path
        A recording (.mcap file); a folder, which is searched with all folders in it; or a list of
        recordings and folders. A recording that is named twice is loaded once.

    Returns
    -------
    Dataset
        Pinches with their labels. Copies of recordings, and pinches with missing samples, are left
        out and named in ``losses``.

    Raises
    ------
    InputError
        No recording exists or can be read, or two recordings differ in channels, sampling rate or
        source (simulated or real).

    Examples
    --------
    >>> import firstcontact as fc
    >>> data = fc.load("recordings")
    >>> data
    Dataset(60 pinches, 5 objects, 10 sessions, 4936 Hz, source='twin')
    """
    from firstcontact.recording import load_dataset

    return load_dataset(path)


def plot(subject: Pinch | Dataset | Predictions | Evaluation) -> Any:
    """Draw a pinch, a dataset, predictions or an evaluation with Matplotlib.

    Parameters
    ----------
    subject
        For a pinch, all its channels are drawn over time. For a dataset: the vibration after the
        first contact, coloured by hardness. For predictions: each value with its interval. For an
        evaluation: the error over the time after the contact.

    Returns
    -------
    matplotlib.axes.Axes
        Axes of a new figure; for a pinch an array of axes, one for each kind of channel.

    Raises
    ------
    InputError
        Matplotlib is not installed, or objects of this type cannot be drawn.

    Examples
    --------
    >>> import matplotlib
    >>> matplotlib.use("agg")
    >>> import firstcontact as fc
    >>> axes = fc.plot(fc.load("recordings"))
    >>> axes.get_xlabel()
    'time since first contact (ms)'
    """
    from firstcontact.core.installation import require_modules
    from firstcontact.plots.notebook import DRAWINGS
    from firstcontact.plots.style import PLAIN

    if type(subject) not in DRAWINGS:
        raise ArgumentError(
            f"an object of type {type(subject).__name__} cannot be drawn: give a Pinch, a Dataset, "
            "Predictions or one Evaluation",
            parameter="subject",
        )
    require_modules("plot", "matplotlib")
    from matplotlib import pyplot, rc_context

    with rc_context(PLAIN):
        return DRAWINGS[type(subject)](subject, pyplot.figure(layout="constrained"))


def import_recordings(
    path: AnyPath,
    out: AnyPath,
    *,
    rate: float | None = None,
    source: str | None = None,
    sensor: str | None = None,
    events: AnyPath | None = None,
    channels: AnyPath | None = None,
    labels: AnyPath | None = None,
    find: bool = False,
) -> Dataset:
    """Convert sensor data in other file formats into recordings (.mcap files).

    Parameters
    ----------
    path
        File or folder: WAV, FLAC, XDF, MATLAB, HDF5, NPZ, CSV, or a format that a plug-in reads.
    out
        Folder for the recordings; it must be empty or new.
    rate
        Sampling rate, Hz, for a format that does not store it.
    source
        Origin of the data, "real", "twin" (simulated) or "synthetic", for a format that does not
        store it.
    sensor
        "piezo", "accelerometer", "microphone" or "hydrophone", for a format that does not store it.
    events, channels, labels
        Paths of CSV tables: ``events`` lists the contacts in long files (columns file, onset_s and
        labels), ``channels`` names the signals, and ``labels`` labels the files (columns file,
        object, shore_a, session and others). ``labels.csv`` in the folder is read by default.
    find
        True to detect the contacts in WAV and FLAC files, and cut out one pinch for each.

    Returns
    -------
    Dataset
        Pinches in the new recordings, in the order in which :func:`load` returns them: session by
        session, in the order of the sessions' first pinches. ``notes`` lists every assumption.

    Raises
    ------
    InputError
        The input cannot be used, or ``out`` is not empty. Nothing is written then.

    Examples
    --------
    >>> import numpy as np
    >>> import firstcontact as fc
    >>> rng = np.random.default_rng(0)
    >>> signals = rng.normal(0, 0.002, (4, 3000, 2))  # shape (pinches, samples, fingers)
    >>> labels = {"shore_a": [10.0, 10.0, 60.0, 60.0]}
    >>> np.savez("taps.npz", piezo=signals, piezo_unit="V", sample_rate_hz=4936.0, **labels)
    >>> data = fc.import_recordings("taps.npz", "imported", source="synthetic")
    >>> len(data), data.source
    (4, 'synthetic')
    """
    from firstcontact.contact.finder import find_onsets
    from firstcontact.recording import import_path

    onsets = find_onsets if find else None
    return import_path(path, out, rate, source, sensor, events, channels, labels, onsets)


def simulate(
    out: AnyPath,
    *,
    condition: Literal["paper-rig", "everyday"] = "paper-rig",
    pinches_per_block: int = 500,
    pinches_per_object: int = 50,
    seed: int = 0,
    workers: int | None = None,
    noise: AnyPath | None = None,
    positions: bool = False,
    progress: Progress = None,
) -> Dataset:
    """Simulate labelled pinches of five flat blocks and eight other objects with a simulated hand.

    Parameters
    ----------
    out
        Folder for the recordings; it must be empty or new.
    condition
        Variation between pinches: "paper-rig" as in the published set-up, "everyday" as outside a
        lab.
    pinches_per_block, pinches_per_object
        Number of pinches with each of the five blocks, and with each of the eight other objects.
    seed
        Random seed. The same seed gives files with the same bytes.
    workers
        Number of threads; all cores by default. It does not change the result.
    noise
        Path of a recording of a real sensor at rest. Its noise replaces the simulated noise of the
        electronics and the simulated hum.
    positions
        True to simulate a hand that reports its positions, so that each pinch has a measured
        ``closing_speed``.
    progress
        True to show a bar, or a function that is called with the number of pinches just finished.

    Returns
    -------
    Dataset
        The simulated pinches.

    Raises
    ------
    InputError
        A parameter is out of range, or ``out`` is not empty.

    Examples
    --------
    >>> import firstcontact as fc
    >>> data = fc.simulate("few", pinches_per_block=2, pinches_per_object=0)
    >>> len(data), data.source
    (10, 'twin')
    """
    from firstcontact.core.files import given_path
    from firstcontact.twin import simulate as simulate_set
    from firstcontact.twin.noise import read_noise

    recorded = None if noise is None else read_noise(Path(noise))
    sizes = pinches_per_block, pinches_per_object
    simulate_set(
        given_path(out, "out"), condition, *sizes, seed, workers, progress, recorded, positions
    )
    return load(out)


def sample(name: Literal["paper-rig", "everyday", "strikes"] = "paper-rig") -> Dataset:
    """Return simulated example data. The first call simulates them and stores them on disk.

    Parameters
    ----------
    name
        "paper-rig" or "everyday": 190 labelled pinches as :func:`simulate` makes them with that
        ``condition``. "strikes": 60 strikes on five blocks, heard by one piezo at a sound input.

    Returns
    -------
    Dataset
        Simulated pinches or strikes. Their recordings are in ``~/.cache/firstcontact``.

    Raises
    ------
    InputError
        No example data have that name.

    Examples
    --------
    >>> import firstcontact as fc
    >>> fc.sample("strikes")
    Dataset(60 pinches, 5 objects, 1 session, 4936 Hz, source='twin')
    """
    from firstcontact.core.files import cache_path, make_once
    from firstcontact.recording import Header, write_dataset
    from firstcontact.streaming.twin import RECIPE
    from firstcontact.twin import CONDITIONS
    from firstcontact.twin import simulate as simulate_set
    from firstcontact.twin.strikes import strikes

    names = (*CONDITIONS, "strikes")
    if name not in names:
        raise ArgumentError(f"{name!r} must be one of {', '.join(names)}", parameter="name")
    folder = cache_path(f"sample-{version('firstcontact')}.{RECIPE}-{name}")

    def make(making: Path) -> None:
        if name == "strikes":
            made = strikes(12, seed=0)
            making.mkdir()
            write_dataset(made, making, Header(made.layout, source="twin", dtype="float32"))
        else:
            simulate_set(making, name, 30, 5, seed=0)

    make_once(folder, make)
    return load(folder)


def detect(data: Dataset, detector: Detector | Model | str | None = None) -> list[Contact | None]:
    """Detect the first contact in each pinch, with the same result as in a live session.

    Parameters
    ----------
    data
        Pinches. They are resampled if the detector needs another rate. Their labelled contacts are
        used only to fit a detector that is given by name.
    detector
        A fitted detector, a model (its detector is used), or the name of a detector to fit to
        ``data``. By default the detector that is shipped with the package.

    Returns
    -------
    list
        First contact of each pinch, in the sample numbers of ``data``; None where none was
        detected.

    Raises
    ------
    InputError
        ``data`` has no pinches, no detector has that name, or the detector cannot use the pinches.

    Examples
    --------
    >>> import firstcontact as fc
    >>> data = fc.load("recordings")
    >>> contacts = fc.detect(data)
    >>> first = contacts[0]
    >>> first.finger in (fc.Finger.INDEX, fc.Finger.THUMB)
    True
    """
    from firstcontact.contact.detector_file import pretrained_detector
    from firstcontact.models import Model
    from firstcontact.models.alignment import detect_alignment, fit_detector
    from firstcontact.models.model import require_dataset

    require_dataset(data)
    if detector is None:
        detector = pretrained_detector()
    elif isinstance(detector, Model):
        detector = detector.own_detector
    elif isinstance(detector, str):
        detector = fit_detector(data, detector)
    elif not hasattr(detector, "chain_constants"):
        raise ArgumentError(
            f"{detector!r} is not a detector: give a fitted detector, a model, or a name",
            parameter="detector",
        )
    return list(detect_alignment(data, detector).contacts)
