"""Public functions that make, read and describe recordings."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Literal

from firstcontact.core import InputError, Role, cores

if TYPE_CHECKING:
    from collections.abc import Iterator

    from firstcontact.collect import Judged
    from firstcontact.contact import Detector
    from firstcontact.core import AnyPath, Calibration, Contact, Dataset, Label, VibrationSensor
    from firstcontact.device import Source

#: True for a progress bar on standard error, or a function that is called with finished steps.
Progress = bool | Callable[[int], object]

#: Rest that is measured where no calibration is given, and the longest wait for it, s.
REST = 2.0
PATIENCE = 10.0


def load(path: AnyPath | Iterable[AnyPath]) -> Dataset:
    """Load the pinches of recordings.

    Parameters
    ----------
    path
        A recording, a folder that is searched with all folders in it, or several of these.

    Returns
    -------
    Dataset
        Pinches with their labels, layout and provenance.

    Raises
    ------
    InputError
        There is no recording, none can be read, or two differ in layout, rate or source.

    Examples
    --------
    >>> import firstcontact as fc
    >>> data = fc.load("recordings")  # doctest: +SKIP
    """
    from firstcontact.recording import load_dataset

    return load_dataset(path if isinstance(path, str | os.PathLike) else list(path))


def import_recordings(
    path: AnyPath,
    out: AnyPath,
    *,
    rate: float | None = None,
    source: str | None = None,
    sensor: VibrationSensor | None = None,
    events: AnyPath | None = None,
    channels: AnyPath | None = None,
    labels: AnyPath | None = None,
) -> Dataset:
    """Convert files of another format into recordings.

    Parameters
    ----------
    path
        File or folder: WAV, FLAC, XDF, MATLAB, HDF5, NPZ, CSV, or what a plug-in reads.
    out
        Folder for the recordings; it must be empty or new.
    rate
        Sampling rate, Hz, for a format that does not store it.
    source
        "real", "twin" or "synthetic", for a format that does not store it.
    sensor
        Kind of vibration sensor, for a format that does not store it.
    events, channels, labels
        Tables of contacts in long files, of signal names, and of labels of files.

    Returns
    -------
    Dataset
        The pinches that were written; its notes list every assumption.

    Raises
    ------
    InputError
        The input cannot be used, or ``out`` holds files. Nothing is written then.
    """
    from firstcontact.recording import import_path

    return import_path(path, out, rate, source, sensor, events, channels, labels)


def simulate(
    out: AnyPath,
    *,
    condition: Literal["paper-rig", "everyday"] = "paper-rig",
    pinches_per_block: int = 500,
    pinches_per_object: int = 50,
    seed: int = 0,
    workers: int | None = None,
    progress: Progress = False,
) -> Dataset:
    """Simulate labelled pinches of five blocks and eight objects on the twin.

    Parameters
    ----------
    out
        Folder for the recordings; it must be empty or new.
    condition
        Variation as in the published set-up, or as outside a lab.
    pinches_per_block, pinches_per_object
        Number of pinches of each.
    seed
        The same seed writes the same bytes.
    workers
        Threads; all cores by default.
    progress
        True shows a bar; a function is called with the number of finished pinches.

    Returns
    -------
    Dataset
        The simulated pinches.

    Raises
    ------
    InputError
        A parameter is out of range, or ``out`` holds files.

    Examples
    --------
    >>> from tempfile import TemporaryDirectory
    >>> import firstcontact as fc
    >>> with TemporaryDirectory() as folder:
    ...     data = fc.simulate(folder + "/pinches", pinches_per_block=2, pinches_per_object=0)
    >>> len(data), data.source
    (10, 'twin')
    """
    from firstcontact.twin import simulate as simulate_set

    total = 5 * pinches_per_block + 8 * pinches_per_object
    with progress_steps(progress, total, "pinch") as step:
        simulate_set(
            Path(out),
            condition,
            pinches_per_block,
            pinches_per_object,
            seed,
            workers or cores(),
            step,
        )
    return load(out)


def calibrate(source: Source, *, seconds: float = REST, patience: float = PATIENCE) -> Calibration:
    """Measure the noise floor of each finger while the hand is open and still.

    Parameters
    ----------
    source
        An open source.
    seconds
        Length of rest that is measured, s.
    patience
        Longest additional wait for that rest, s.

    Raises
    ------
    InputError
        The hand does not rest, or a sensor is dead.
    """
    from firstcontact.device import measure_noise

    return measure_noise(source, seconds, patience)


def detect(data: Dataset, detector: Detector | str | None = None) -> list[Contact | None]:
    """Detect the first contact in each pinch, as the live detector reports it.

    Parameters
    ----------
    data
        Pinches; their labelled contacts are not used, unless a name is given.
    detector
        A fitted detector; or the name of one, which is then fitted to ``data``. The default is
        the detector that is shipped with the package.

    Returns
    -------
    list
        One contact a pinch; None where none was detected.

    Raises
    ------
    InputError
        No detector has that name, or it cannot use these pinches.
    """
    from firstcontact.contact import pretrained_detector
    from firstcontact.models import fit_detector, found

    if detector is None:
        detector = pretrained_detector()
    elif isinstance(detector, str):
        detector = fit_detector(data, detector)
    return list(found(data, detector).contacts)


def record(
    source: Source,
    out: AnyPath,
    *,
    object: str,
    pinches: int = 10,
    shore_a: float | None = None,
    specimen: str = "",
    session: str = "1",
    role: Literal["train", "test"] = "train",
    calibration: Calibration | None = None,
    notes: str = "",
    progress: Progress = False,
    stopped: Callable[[], bool] = lambda: False,
) -> Path:
    """Record pinches of one object until enough of them are valid.

    Every sample that the source delivers is kept. Close the hand yourself, in another thread or
    by its own control. The simulated hand closes by itself, on the object that has this name
    among its own, such as "block 29" or "apple".

    Parameters
    ----------
    source
        An open source. It is closed at the end.
    out
        Folder for the recording; sessions in it are continued in a further file.
    object, shore_a, specimen, role
        Label of the pinches.
    pinches
        Number of valid pinches.
    session
        Name of the session.
    calibration
        Noise floors; measured first by default.
    notes
        For the header.
    progress
        True shows a bar; a function is called with 1 for each valid pinch.
    stopped
        Polled several times a second; recording ends early when it returns True.

    Returns
    -------
    Path
        The recording.

    Raises
    ------
    InputError
        The source fails or ends too early, or the recording cannot be written. Samples that were
        written stay.
    """
    from firstcontact.collect import Guide, Item, header_of, run_session, so_far

    if role not in tuple(Role):
        raise InputError(f"{role!r} is none of {', '.join(Role)}", parameter="role")
    item = Item(object, pinches, shore_a, specimen, Role(role))
    folder = Path(out)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(
            f"out: {folder} cannot be made ({error.strerror}): choose another"
        ) from error
    before = so_far(folder, session, source.descriptor)
    if before.files and before.done[item.label(session)] >= pinches:
        return before.files[-1]
    if calibration is None:
        calibration = calibrate(source)
    guide = Guide(source.descriptor.layout, (item,), session, calibration, before.done)
    header = header_of(source.descriptor, session, calibration, notes=notes)
    with progress_steps(progress, pinches, "pinch") as step:
        complete = run_session(source, guide, before.path, header, _Counting(step), stopped)
    if not complete and not stopped():
        raise InputError(
            f"the source ended before {pinches} valid pinches: what came is in {before.path}",
            parameter="source",
        )
    return before.path


class _Counting:
    """Screen of a recording without a terminal: counts valid pinches."""

    def __init__(self, step: Callable[[int], object]) -> None:
        self._step = step

    def next_object(self, label: Label, done: int, wanted: int) -> bool:
        """Return True: the object is in place."""
        return True

    def in_place(self) -> bool:
        """Return True: the object is in place."""
        return True

    def judged(self, judged: Judged) -> None:
        """Count a valid pinch."""
        if not judged.faults:
            self._step(1)

    def going_on(self) -> None:
        """Do nothing."""


@contextmanager
def progress_steps(
    progress: Progress, total: int | None, unit: str
) -> Iterator[Callable[[int], object]]:
    """Give a function that counts finished steps, with a bar where one is wanted."""
    if callable(progress):
        yield progress
    elif progress:
        from tqdm import tqdm

        with tqdm(total=total, unit=unit) as bar:
            yield bar.update
    else:
        yield lambda done: None
