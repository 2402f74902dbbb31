"""Grasp modulation: policies and the hands that they command."""

from ._grip import Grip as Grip
from ._safe import SafeHand as SafeHand
from .hand import Hand as Hand
from .hand import HandError as HandError
from .hand import HandLimits as HandLimits
from .policy import Policy as Policy
from .registry import HANDS as HANDS
from .registry import POLICIES as POLICIES
from .registry import open_hand as open_hand
