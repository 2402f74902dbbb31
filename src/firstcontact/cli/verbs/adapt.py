"""Command ``firstcontact adapt``: a model of your own rig, in seconds."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, ClassVar

from firstcontact.cli.options import Option, choice
from firstcontact.contact import DETECTORS
from firstcontact.models import ESTIMATORS


@dataclass(frozen=True)
class Adapt:
    """Make a model of your rig from a few pinches of known Shore A.

    The model averages the pre-trained network with a regression that is fitted to your pinches.
    """

    data: Annotated[Path | None, Option(positional=True)] = None
    """Recordings with known Shore A; if you give none, intervals are wide."""
    out: Path = Path("model")
    """Folder for the model; an existing model is replaced."""
    estimator: Annotated[str | None, choice(ESTIMATORS, "model")] = None
    """Estimator of the stiffness after a contact; by default combined."""
    detector_type: Annotated[str | None, choice(DETECTORS, "model")] = None
    """Detector to fit; by default the package's, if no fitted one is better."""
    seed: int = 0
    """Random seed of the split of the pinches into cross-validation folds."""

    #: Options whose parameter of the library has another name.
    options: ClassVar[dict[str, str]] = {"detector": "detector_type"}

    def run(self) -> None:
        from firstcontact.core.files import replacing_folder
        from firstcontact.models import adapt
        from firstcontact.models.model_file import check_replaceable
        from firstcontact.recording import load_dataset

        former = check_replaceable(self.out, (), network=True)
        data = None if self.data is None else load_dataset(self.data)
        with replacing_folder(self.out) as making:
            model = adapt(
                data, estimator=self.estimator, detector=self.detector_type, seed=self.seed
            )
            model.write(making)
        for line in model.notes:
            print(line)
        rig = "of an unknown rig " if data is None else ""
        print(f"wrote the network {rig}and the detector {model.own_detector.name} to {self.out}")
        if former:
            print(f"replaced the former model in {self.out}")
