"""Answers at any time after a contact, for any rig, each with an interval."""

from firstcontact.anytime._model import Answers, AnytimeModel
from firstcontact.anytime.in_context import InContextModel
from firstcontact.anytime.rig import Rig
from firstcontact.anytime.touches import Touches, touches_of

__all__ = ["Answers", "AnytimeModel", "InContextModel", "Rig", "Touches", "touches_of"]
