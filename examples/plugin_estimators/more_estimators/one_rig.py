"""Any-time estimator: the network, with both fingers always described as one rig.

The chain in C computes its predictions, because the model has the constants of the network.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import InputError
from firstcontact.models import Rig, Touches
from firstcontact.models.in_context import InContextModel
from firstcontact.models.model_file import pretrained
from firstcontact.models.network_estimator import Adapted, NetworkEstimator
from firstcontact.models.window_model import Values


class OneRigModel(InContextModel):
    """Network conditioned on all pinches of both fingers."""

    kind: ClassVar[str] = "one_rig"


@dataclass(frozen=True)
class OneRig(NetworkEstimator):
    """Estimator that makes one rig of all pinches, and holds none out."""

    name: ClassVar[str] = OneRigModel.kind
    title: ClassVar[str] = "Network, one rig"
    model: ClassVar[Any] = OneRigModel

    def fit_touches(
        self,
        touches: Touches,
        shore_a: Values,
        sessions: NDArray[np.str_] | None = None,
        seed: int = 0,
    ) -> Adapted:
        """Describe the rig by all contacts that are long enough."""
        usable = touches.answerable
        if len(np.unique(shore_a[usable])) < 2:
            raise InputError("a rig needs pinches of two values of Shore A: record another block")
        base = pretrained()
        rig = Rig.fit(touches.take(usable), shore_a[usable])
        model = OneRigModel(
            base.network, base.familiar, base.factors, base.level, {Rig.ANY: rig}, base.mixed
        )
        return Adapted(model, {})
