"""Training of the detector and models for the payload task, on pinches by the same hand.

The pinches for training are not those that are scored.
"""

from __future__ import annotations

import shutil
from pathlib import Path

import firstcontact as fc
from firstcontact.core import InputError
from firstcontact.twin import simulate
from firstcontact_lab.grasping.results import ModelErrors
from firstcontact_lab.grasping.settings import GraspStudySettings
from firstcontact_lab.report.folder import MARK, fresh

#: Condition of the training pinches. The twin names their sessions "blocks-01" and so on.
CONDITION = "paper-rig"


def learn(settings: GraspStudySettings, out: Path) -> fc.Model:
    """Simulate pinches, train a detector and a window model for each length, and save them."""
    models = out / "models"
    # A study makes models after marked recordings. Without these, no study made the models.
    if models.exists() and not (out / "recordings" / MARK).exists():
        raise InputError(
            f"{models} was not made by a grasp study: choose another --out, or move it away"
        )
    recordings = fresh(out / "recordings", {"twin": CONDITION, "seed": settings.seed})
    if models.exists():
        shutil.rmtree(models)
    simulate(
        recordings / "pinches", CONDITION, settings.training, 0, settings.seed, settings.workers
    )
    model = fc.train(
        fc.load(recordings),
        settings.model,
        detector=settings.detector,
        windows=settings.windows,
        seed=settings.seed,
        workers=settings.workers,
    )
    return fc.load_model(model.save(models))


def held_out_errors(model: fc.Model) -> ModelErrors:
    """Return a model's errors and interval widths on held-out sessions, by window length, ms."""
    rmse, width = {}, {}
    for window in model.windows:
        key = f"{1e3 * window.duration:g}"
        rmse[key] = window.record.scores["rmse"]
        held_out = window.record.calibration.get("held_out") or {}
        width[key] = float(held_out.get("mean_width", 0.0))
    return ModelErrors(rmse=rmse, interval_width=width)
