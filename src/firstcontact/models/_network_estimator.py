"""Pre-trained network as an estimator: its fit summarises the rig of the training pinches."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

from numpy.typing import NDArray

from firstcontact.core import GREEN, InputError
from firstcontact.models._adapting import Adapted, adapt_network
from firstcontact.models._anytime_file import pretrained
from firstcontact.models._estimator import Estimator
from firstcontact.models._in_context import InContextModel
from firstcontact.models._labelled_touches import LabelledTouches
from firstcontact.models._spec import Task, Values, Windows


@dataclass(frozen=True)
class NetworkEstimator(Estimator):
    """Network that was trained on simulated rigs and is conditioned on one rig.

    Nothing is trained: the pinches of the rig become an input of the network.
    """

    name: ClassVar[str] = InContextModel.kind
    title: ClassVar[str] = "Network"
    colour: ClassVar[str] = GREEN
    tasks: ClassVar[tuple[Task, ...]] = (Task.REGRESSION,)
    takes_windows: ClassVar[bool] = False

    def fit(self, X: Windows, y: Values, groups: NDArray[Any] | None = None, seed: int = 0) -> Any:
        """Refuse windows: the network takes whole contacts, with the quiet before them."""
        raise InputError(
            "network takes whole contacts and not windows: use train or adapt",
            parameter="estimator",
        )

    def fit_contacts(self, labelled: LabelledTouches, seed: int = 0) -> Adapted:
        """Condition the pre-trained network on labelled contacts of a rig.

        Parameters
        ----------
        labelled
            Contacts with a Shore A.
        seed
            Of the folds that hold contacts out.

        Raises
        ------
        InputError
            The contacts do not describe a rig.
        """
        return adapt_network(
            pretrained(), labelled.touches, labelled.shore_a, labelled.named_sessions, seed
        )
