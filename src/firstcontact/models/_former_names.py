"""Former names, until the lab and `streaming` use the new ones."""

from firstcontact.models._context_network import ContextNetwork
from firstcontact.models._context_network import ContextNetwork as Network
from firstcontact.models._predictors import RigPredictor as NetworkPredictor
from firstcontact.models._rig import Rig
from firstcontact.models._touches import Touches, radius_text

THIN, FARTHEST, COMPONENTS = ContextNetwork.THIN, ContextNetwork.FARTHEST, ContextNetwork.COMPONENTS
ANY = Rig.ANY
STAGES, TOKEN, GENERAL, LEVELS = Rig.STAGES, Rig.TOKEN, Rig.GENERAL, Rig.LEVELS
USUAL_LEVEL, stage_index = Rig.USUAL_LEVEL, Rig.stage_index
BEFORE, LONGEST, TIMES = Touches.BEFORE, Touches.LONGEST, Touches.SCORED_MS
lengths, moments, in_words = Touches.lengths, Touches.moments, radius_text
cut_touch, cut_touches = Touches.cut_signal, Touches.cut
__all__ = ["Network", "NetworkPredictor"]
