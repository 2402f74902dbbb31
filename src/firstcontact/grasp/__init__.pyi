"""Grasp modulation: policies and the hands that they command."""

from ._grip import Grip as Grip
from ._hand import Begins as Begins
from ._hand import Hand as Hand
from ._hand import HandError as HandError
from ._hand import HandLimits as HandLimits
from ._loop import GraspLoop as GraspLoop
from ._loop import LoopCounts as LoopCounts
from ._policy import ForceArray as ForceArray
from ._policy import Part as Part
from ._policy import Policy as Policy
from ._policy import SensorVariant as SensorVariant
from ._policy import Task as Task
from ._policy import Truth as Truth
from ._registry import HANDS as HANDS
from ._registry import make_hand as make_hand
from ._registry import open_hand as open_hand
from ._safe import SafeHand as SafeHand
from ._taxels import Taxels as Taxels
from .policies.final_force import APPROACH as APPROACH
from .policies.final_force import FinalForce as FinalForce
from .policies.reflex import BOOST as BOOST
from .policies.registry import POLICIES as POLICIES
from .policies.registry import live_policies as live_policies
from .policies.registry import live_policy as live_policy
from .policies.registry import make_policy as make_policy
from .policies.stiffness import ByStiffness as ByStiffness
