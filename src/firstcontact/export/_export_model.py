"""Function that exports a trained model in one of the registered formats."""

from __future__ import annotations

from firstcontact.core import ArgumentError, Dataset
from firstcontact.core.files import AnyPath, given_path, replacing_folder
from firstcontact.core.installation import require_extra
from firstcontact.export.budget import small_enough
from firstcontact.export.registry import MODEL_EXPORTERS
from firstcontact.models import Model, load_model
from firstcontact.models.training_runs import training_pinches
from firstcontact.signal import resample_dataset


def export_model(
    model: AnyPath | Model,
    out: AnyPath,
    *,
    to: str = "c",
    data: Dataset | None = None,
    budget_us: float | None = None,
    estimator: str | None = None,
) -> list[str]:
    """Export a trained model to C99 code, or its convolutional networks (CNN) to ONNX.

    C99 code has the contact detector, and the network with its regressions or an SVM.

    Parameters
    ----------
    model
        Model, or its folder.
    out
        Folder for the files; it must be empty or new.
    to
        Name in ``firstcontact.plugins.MODEL_EXPORTERS``: "c" or "onnx".
    data
        Training pinches. If a window model is too slow for ``budget_us``, a smaller one is fitted
        to these pinches. They are resampled if their rate differs from the model's. Pinches with
        role "test" are ignored.
    budget_us
        Longest allowed computing time of a window model on a Cortex-M7 at 600 MHz, us.
    estimator
        Name of the estimator to export, by default the first one of the model.

    Returns
    -------
    list of str
        Sentences about what was written.

    Raises
    ------
    InputError
        The model cannot be written in this format, or is slower than ``budget_us``. Nothing is
        written then.

    Examples
    --------
    >>> import firstcontact as fc
    >>> data = fc.load("recordings")
    >>> written = fc.export_model(fc.adapt(data), "c-code", to="c", data=data)
    """
    exporter = MODEL_EXPORTERS.find(to)
    require_extra(exporter)
    place = given_path(out, "out")
    if place.exists() and (not place.is_dir() or any(place.iterdir())):
        raise ArgumentError(
            f"{place} is not an empty folder: give an empty or a new folder", parameter="out"
        )
    if budget_us is not None and not 0.0 < budget_us <= 1e6:
        raise ArgumentError(
            f"the time limit of a prediction is {budget_us:g} us: give more than 0 and at most "
            "1000000 us",
            parameter="budget_us",
        )
    learned = None if data is None else training_pinches(data)
    loaded = model if isinstance(model, Model) else load_model(model)
    loaded = loaded if estimator is None else loaded.only(estimator)
    if learned is not None and loaded.predictors:
        learned = resample_dataset(learned, loaded.rate)
    if budget_us is not None:
        loaded = small_enough(loaded, learned, budget_us)
    with replacing_folder(place) as making, MODEL_EXPORTERS.convert_errors(to):
        return list(exporter.write(loaded, making))
