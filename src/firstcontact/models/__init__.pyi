"""Models: estimators, one a file; training, evaluation, intervals; the model folder."""

from ._evaluate import Evaluation as Evaluation
from ._evaluate import GroupScores as GroupScores
from ._evaluate import evaluate as evaluate
from ._predictors import RigPredictor as RigPredictor
from ._predictors import WindowPredictor as WindowPredictor
from .estimator import Estimator as Estimator
from .estimator import training_spec as training_spec
from .interval import Interval as Interval
from .model import Model as Model
from .model import load_model as load_model
from .predictions import Predictions as Predictions
from .registry import ESTIMATORS as ESTIMATORS
from .registry import make_estimator as make_estimator
from .rig import Rig as Rig
from .touches import Touches as Touches
from .training import LabelledTouches as LabelledTouches
from .training import LabelledWindows as LabelledWindows
from .training_runs import adapt as adapt
from .training_runs import train as train
from .window_model import ArraysModel as ArraysModel
from .window_model import Spec as Spec
from .window_model import Task as Task
from .window_model import WindowModel as WindowModel
from .window_model import Windows as Windows
