"""Pre-training of the package's network: simulate rigs, then train, calibrate and score."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray

from firstcontact.core.layout import FINGERTIP_RATE
from firstcontact.jobs import Runner, Serial
from firstcontact.models import Model, Touches
from firstcontact.models.card import TrainingRecord
from firstcontact.models.rig.rig_model import RigModel
from firstcontact.models.rig.rigs import Rig
from firstcontact.signal import samples_in
from firstcontact_lab.pretraining.calibration import (
    LEVEL,
    PINCHES,
    calibrate_average,
    calibrate_network,
    object_errors,
    same_object,
)
from firstcontact_lab.pretraining.compact_training import STEPS, train_compact
from firstcontact_lab.pretraining.examples import DRAWN, example_set
from firstcontact_lab.pretraining.training import Full, Training
from firstcontact_lab.rigs import FAMILIES

#: First rig numbers for training, calibration, judgement and held-out families.
TRAINED, CALIBRATED, JUDGED, HELD_OUT = 0, 1_000_000, 2_000_000, 3_000_000
#: First rig numbers of sets with repeated pinches of each object, for calibrating the shared error
#: and for judging it.
AGAIN, AGAIN_JUDGED = 4_000_000, 5_000_000
#: Distance between the seeds of two teachers.
APART = 1000
#: Samples after the contact at which the network is judged: 3, 5, 8 and 15 ms.
SAMPLES = {str(ms): samples_in(ms / 1000, FINGERTIP_RATE) for ms in Touches.SCORED_MS[1:]}


@dataclass(frozen=True, slots=True)
class Size:
    rigs: int = 6000
    calibration: int = 300
    judgement: int = 100
    held_out: int = 50
    epochs: int = 45
    steps: int = STEPS
    teachers: int = 4

    def resized(self, rigs: int, epochs: int, teachers: int) -> Size:
        share = min(1.0, rigs / self.rigs)
        return Size(
            rigs,
            max(20, round(share * self.calibration)),
            max(10, round(share * self.judgement)),
            max(5, round(share * self.held_out)),
            epochs,
            max(200, round(share * self.steps)),
            teachers,
        )


def pretrain(
    out: Path, work: Path, size: Size, seed: int, runner: Runner, say: Callable[[str], object]
) -> RigModel:
    """Pre-train the network, or resume a stopped pre-training. Return the model.

    Several uncompressed networks (teachers) are trained on the same rigs with different random
    numbers. The compact network learns the mean of their distributions, so it depends less on the
    random numbers of one teacher. ``out`` is the folder of the model, ``work`` that of intermediate
    files.
    """
    torch.set_num_threads(1)  # the number of threads decides the last bits of sums
    examples = example_set(work, TRAINED, size.rigs, seed, runner)
    say(f"{size.rigs} rigs, {len(examples)} contacts for training")
    teachers = []
    for number, full in enumerate(
        runner.stream(_train_teacher, range(size.teachers), work, size, seed)
    ):
        say(f"network {number + 1} of {size.teachers} is trained")
        teachers.append(full)
    network = train_compact(
        teachers,
        examples,
        seed,
        size.steps,
        progress=lambda step, loss: say(f"compact, step {step} of {size.steps}: loss {loss:.3f}"),
    )
    calibration = example_set(work, CALIBRATED, size.calibration, seed, runner)
    model = calibrate_network(network, calibration, seed)
    model = calibrate_average(model, range(CALIBRATED, CALIBRATED + size.calibration), seed, runner)
    scores = all_scores(model, work, size, seed, runner)
    trained = (
        f"{size.rigs} random simulated rigs, {size.epochs} epochs, {size.teachers} teachers, "
        f"seed {seed}"
    )
    record = TrainingRecord(scores=scores, training={"trained": trained, "size": asdict(size)})
    Model(predictors=(model.with_record(record),)).write(out)
    return model


def _train_teacher(number: int, work: Path, size: Size, seed: int) -> Full:
    """Train the ``number``-th uncompressed (teacher) network, or resume its training.

    The files of the training examples must exist.
    """
    torch.set_num_threads(1)
    examples = example_set(work, TRAINED, size.rigs, seed, Serial())
    state = work / f"training-v{DRAWN}-{seed}-{size.rigs}-{size.epochs}-{number}.pt"
    return Training(examples, size.epochs, seed + APART * number, state).run()


def all_scores(
    model: RigModel, work: Path, size: Size, seed: int, runner: Runner
) -> Mapping[str, Mapping[str, Any]]:
    """Return the scores of the model on other random rigs, on families, and of pooled pinches."""
    scores: dict[str, Mapping[str, Any]] = {}

    def judge(title: str, first: int, rigs: int, family: str = "") -> None:
        network, average = object_errors(model, range(first, first + rigs), seed, runner, family)
        scores[title] = scores_by_time(network, model.factors)
        scores[f"{title}, averaged"] = scores_by_time(average, model.mixed)

    judge("random rigs", JUDGED, size.judgement)
    for name, family in FAMILIES.items():
        judge(f"held out: {family.title}", HELD_OUT, size.held_out, name)
    calibration, test = (
        example_set(work, at, size.judgement, seed, runner, PINCHES) for at in (AGAIN, AGAIN_JUDGED)
    )
    scores["same object"] = same_object(model, calibration, test, SAMPLES, seed + 1)
    return scores


def scores_by_time(errors: NDArray[np.float64], factors: NDArray[np.float64]) -> Mapping[str, Any]:
    """Return RMSE, bias, coverage and interval width, by time in ms.

    ``errors`` is one entry of :func:`object_errors`, for the network or for the average.
    ``factors`` lead from standard deviations to half widths.
    """
    out: dict[str, Any] = {}
    for time, samples in SAMPLES.items():
        stage = int(Rig.stage_index(samples))
        away, spreads = errors[:, stage, np.isfinite(errors[0, stage])]
        half = factors[stage] * spreads
        out[time] = {
            "rmse": round(float(np.sqrt((away**2).mean())), 2),
            "bias": round(float(away.mean()), 2),
            "coverage": round(float((np.abs(away) <= half).mean()), 3),
            "width": round(float(2 * half.mean()), 1),
        }
    return {"level": LEVEL, "ms": out}
