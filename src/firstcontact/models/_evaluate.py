"""Evaluation of a model on labelled pinches, apart for those that the model was trained on."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import cast

import numpy as np
from numpy.typing import NDArray

from firstcontact.contact import Detector
from firstcontact.core import ArgumentError, Dataset
from firstcontact.core.display import Progress, progress_steps
from firstcontact.core.files import AnyPath
from firstcontact.core.quantity import SHORE_A
from firstcontact.core.records import LONGEST_NAME
from firstcontact.core.text import counted
from firstcontact.models.alignment import (
    Alignment,
    Contacts,
    at_known_contacts,
    detect_alignment,
    label_alignment,
)
from firstcontact.models.anytime import AnytimeModel
from firstcontact.models.card import Digests, Target, TrainingData, pinch_digests
from firstcontact.models.evaluation import Evaluation, GroupScores, Overlap
from firstcontact.models.labelled_data import distinct_specimens, full_specimen, resampling_clusters
from firstcontact.models.model import Model, load_model, require_dataset
from firstcontact.models.model_file import SavedPredictor
from firstcontact.models.predictions import Predictions
from firstcontact.models.scores import (
    TaskScores,
    classification_scores,
    per_object,
    regression_scores,
)
from firstcontact.models.touches import Touches
from firstcontact.models.values import Values
from firstcontact.models.windows.window_predictor import WindowPredictor
from firstcontact.signal import resample_dataset

Mask = NDArray[np.bool_]


def evaluate(
    model: AnyPath | Model,
    data: Dataset,
    *,
    contacts: Contacts = "detected",
    detector: Detector | None = None,
    progress: Progress = None,
) -> tuple[Evaluation, ...]:
    """Score every predictor of a model on labelled pinches.

    Predictions use only samples before the second finger's contact, as in live sessions. This
    contact comes from the data. Objects that the model was trained on are flat blocks, unless their
    labels state another shape.

    Parameters
    ----------
    model
        Model to score, or its folder.
    data
        Labelled pinches. They are resampled if their sampling rate differs from the model's.
    contacts
        "detected": predictions start at contacts that the detector finds, as in live use. "known":
        they start at the contacts in ``data``, which come from contact strips or labels.
    detector
        Fitted contact detector to use instead of the model's own.
    progress
        True to show a bar, or a function that is called with 1 for each scored predictor.

    Returns
    -------
    tuple of Evaluation
        One per predictor, in the order of ``model.predictors``: the default predictor comes first.

    Raises
    ------
    InputError
        No pinch can be scored, or the model consists of a detector only.

    Examples
    --------
    >>> import firstcontact as fc
    >>> data = fc.load("recordings")
    >>> model = fc.adapt()  # the package's network, not adapted to any hand
    >>> for evaluation in fc.evaluate(model, data):
    ...     print(evaluation.scored, "pinches scored at", *evaluation.rmse, "s")
    59 pinches scored at 0.002 0.003 0.005 0.008 0.015 s
    >>> isinstance(evaluation, fc.Evaluation), isinstance(evaluation.groups[0], fc.GroupScores)
    (True, True)
    """
    if not isinstance(model, Model):
        model = load_model(model)
    if detector is not None:
        model = replace(model, detector=detector)
    model.default()  # refuses a detector alone
    require_dataset(data)
    data = model.trained_on.with_shapes(data)
    is_foreign = model.is_foreign(data.layout)
    at_rate: dict[float, tuple[Dataset, Alignment]] = {}

    def aligned(rate: float) -> tuple[Dataset, Alignment]:
        if rate not in at_rate:
            dataset = resample_dataset(data, rate)
            if at_known_contacts(contacts, dataset):
                at_rate[rate] = dataset, label_alignment(dataset)
            else:
                at_rate[rate] = dataset, detect_alignment(dataset, model.own_detector)
        return at_rate[rate]

    out, trained_at = [], model.trained_on.contacts.partition(" ")[0]
    overlap = overlap_groups(data, model.trained_on, model.digests)
    with progress_steps(progress, len(model.predictors), "model", "scoring") as step:
        for predictor in model.predictors:
            at = aligned(predictor.rate)
            out.append(_evaluation(predictor, overlap, trained_at, is_foreign, *at))
            step(1)
    if not any(evaluation.scored for evaluation in out):
        shortest = min(p.prediction_times[0] for p in model.predictors)
        raise ArgumentError(
            f"none of the {len(data)} pinches can be scored: check that pinches have a label "
            f"{model.trained_on.target} that the model can predict, a first contact (here "
            f"{out[0].contacts}), and {1e3 * shortest:.3g} ms of signal between it and the second",
            parameter="data",
        )
    return tuple(out)


def _evaluation(
    predictor: SavedPredictor,
    overlap: Mapping[Overlap, Mask],
    trained_at: str,
    is_foreign: bool,
    dataset: Dataset,
    aligned: Alignment,
) -> Evaluation:
    scored_at: Sequence[float] = predictor.prediction_times
    if len(scored_at) > len(Touches.SCORED_MS):
        scored_at = [ms / 1000 for ms in Touches.SCORED_MS]
    predictions = {at: predictor.predict_pinches(dataset, aligned.contacts, at) for at in scored_at}
    quantity = predictor.quantity
    truth = dataset.shore_a if quantity is SHORE_A else dataset.label_values(quantity)
    if is_foreign:
        odd = np.ones(len(dataset), np.bool_)
        predictions = {at: replace(p, out_of_range=odd) for at, p in predictions.items()}
    values = np.array([p.value for p in predictions.values()])
    has_both = np.isfinite(values).all(axis=0) & np.isfinite(truth)
    is_known = np.isin(truth, predictor.classes) if predictor.classes else has_both
    warnings = _overlap_warnings(overlap, has_both)
    if trained_at == "detected" and aligned.how.startswith("known"):
        warnings.append(
            "warning: the model learned from detected contacts, which come a little later than "
            "known ones, so these errors are too large: score it with detected contacts"
        )
    groups = []
    for title, members in overlap.items():
        unknown = int((members & has_both & ~is_known).sum())
        if unknown:
            warnings.append(
                f"{title}: left out {counted(unknown, 'pinch')} of classes that the model does not "
                "know"
            )
        rows = members & has_both & is_known
        if rows.any():
            groups.append(_score_group(title, predictor, predictions, truth, dataset, rows))
    scored = sum(group.n for group in groups)
    return Evaluation(
        predictor=predictor.name,
        target=cast(Target, quantity.name),
        contacts=aligned.how,
        scored=scored,
        left_out=len(dataset) - scored,
        warnings=tuple(warnings),
        groups=tuple(groups),
        duration=predictor.duration if isinstance(predictor, WindowPredictor) else None,
    )


def _score_group(
    title: Overlap,
    predictor: SavedPredictor,
    predictions: Mapping[float, Predictions],
    truth: Values,
    dataset: Dataset,
    rows: NDArray[np.bool_],
) -> GroupScores:
    """Return the scores of the predictions for the pinches where the mask ``rows`` is True.

    ``title`` names this group of pinches. ``predictions`` are for all pinches, by the time after
    the contact, s.
    """
    specimens, quantity = distinct_specimens(dataset)[rows], predictor.quantity
    scaled = (lambda values: values) if predictor.classes else quantity.scaled
    truth = scaled(truth[rows])
    clusters = resampling_clusters(dataset.sessions[rows], specimens)
    compare = classification_scores if predictor.classes else regression_scores
    scores: dict[float, TaskScores] = {}
    coverage, width, out_of_range = {}, {}, {}
    for at, all_pinches in predictions.items():
        answer = all_pinches.take(rows)
        value, low, high = map(scaled, (answer.value, answer.low, answer.high))
        scores[at] = compare(truth, value, clusters, 0)
        if predictor.level is not None:
            coverage[at] = float(((low <= truth) & (truth <= high)).mean())
            width[at] = float((high - low).mean())
        if isinstance(predictor, AnytimeModel):
            out_of_range[at] = float(answer.out_of_range.mean())
    return GroupScores(
        title=title,
        predictor=predictor.name,
        n=len(truth),
        scores=scores,
        coverage=coverage,
        width=width,
        out_of_range=out_of_range,
        objects=per_object(truth, value, specimens, dataset.objects[rows], quantity),
        constant=None if predictor.classes else float(truth.std()),
        level=predictor.level,
    )


def overlap_groups(
    dataset: Dataset, trained_on: TrainingData, digests: Digests
) -> dict[Overlap, Mask]:
    """Group pinches by their relation to a model's training data, which ``trained_on`` describes.

    Return a mask for each relation, shape (pinches,). The first one marks the pinches that were not
    seen in training. ``digests`` are those of the training pinches. A pinch with role "test" counts
    as not seen unless its digest is among them.
    """
    seen = np.isin(pinch_digests(dataset.pinches), digests)
    unseen = ~dataset.test & ~seen
    specimen = _same_specimen(dataset, trained_on) & unseen
    # Sessions of other sources may have the same names by chance.
    session = np.isin(dataset.sessions, trained_on.sessions) & (dataset.sessions != "") & unseen
    session &= trained_on.source == dataset.source
    is_unnamed = (dataset.specimens == "") & ("" in trained_on.specimens)
    namesakes = session & (specimen | is_unnamed)
    return {
        Overlap.NONE: ~(seen | specimen | session),
        Overlap.SESSION: session & ~namesakes,
        Overlap.SPECIMEN: specimen & ~session,
        Overlap.NAMESAKES: namesakes,
        Overlap.SEEN: seen,
    }


def _overlap_warnings(groups: Mapping[Overlap, Mask], is_scored: Mask) -> list[str]:
    seen, namesakes = (
        int((groups[overlap] & is_scored).sum()) for overlap in (Overlap.SEEN, Overlap.NAMESAKES)
    )
    lines = []
    if seen:
        lines.append(
            f"warning: {seen} pinches have the same samples as training pinches of the model: "
            "they are scored separately and do not show the errors in use"
        )
    if namesakes:
        lines.append(
            f"note: {namesakes} pinches have the session and specimen of training pinches, but "
            "other samples: they may be new, or training pinches that were resampled or cut "
            "again: they are scored separately"
        )
    return lines


def _same_specimen(dataset: Dataset, trained_on: TrainingData) -> Mask:
    """Return a mask of the pinches whose specimen (physical object) is in the training data."""
    full = [full_specimen(pinch.label)[:LONGEST_NAME] for pinch in dataset.pinches]
    is_same: Mask = np.isin(dataset.specimens, trained_on.specimens)
    if trained_on.objects:
        is_same &= np.isin(dataset.objects, ["", *trained_on.objects])
    is_same |= np.isin(full, trained_on.specimens)
    is_same &= dataset.specimens != ""
    return is_same
