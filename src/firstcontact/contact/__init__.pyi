"""Contact detectors, one a file."""

from .contacts import detect as detect
from .detector import Detector as Detector
from .detector_file import general_detector as general_detector
from .detector_file import load_detector as load_detector
from .detector_file import save_detector as save_detector
from .registry import DETECTORS as DETECTORS
from .registry import SLIP_DETECTORS as SLIP_DETECTORS
from .registry import make_detector as make_detector
from .slip import SlipDetector as SlipDetector
from .svm import SvmDetector as SvmDetector
from .threshold import ThresholdDetector as ThresholdDetector
