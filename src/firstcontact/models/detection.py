"""Detection of first contacts by a detector, a model or the name of a detector."""

from __future__ import annotations

from firstcontact.contact import Detector
from firstcontact.contact.detector_file import pretrained_detector
from firstcontact.core import ArgumentError, Contact, Dataset
from firstcontact.models.alignment import detect_alignment, fit_detector
from firstcontact.models.model import Model, require_dataset


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
