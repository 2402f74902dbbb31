"""Models: estimators, one a file; training, evaluation, intervals; the model folder."""

from ._evaluate import evaluate as evaluate
from .anytime import AnytimeModel as AnytimeModel
from .anytime import Hints as Hints
from .anytime import Prediction as Prediction
from .estimator import AnytimeEstimator as AnytimeEstimator
from .estimator import Estimator as Estimator
from .estimator import training_spec as training_spec
from .evaluation import Evaluation as Evaluation
from .model import Model as Model
from .model import load_model as load_model
from .predictions import Predictions as Predictions
from .registry import ESTIMATORS as ESTIMATORS
from .registry import make_estimator as make_estimator
from .touches import Touches as Touches
from .training_runs import adapt as adapt
from .training_runs import train as train
from .values import Task as Task
from .values import Windows as Windows
from .windows.window_model import ModelFromArrays as ModelFromArrays
from .windows.window_model import Spec as Spec
from .windows.window_model import WindowModel as WindowModel
from .windows.window_predictor import WindowPredictor as WindowPredictor
