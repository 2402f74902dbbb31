"""Collecting: guided recording, calibration, and the page on which contacts are labelled."""

from ._calibrate import calibrate as calibrate
from ._calibrate import is_tapped as is_tapped
from ._calibrate import measured_channel as measured_channel
from ._calibrate import rest_request as rest_request
from ._calibrate import rest_words as rest_words
from ._calibrate import tap_words as tap_words
from ._camera import compare as compare
from ._camera import in_words as in_words
from ._camera import read_contacts as read_contacts
from ._force_fit import Weighing as Weighing
from ._force_fit import read_weights as read_weights
from ._guide import Guide as Guide
from ._guide import Item as Item
from ._guide import Judged as Judged
from ._label_result import Labeller as Labeller
from ._label_session import LabelServer as LabelServer
from ._label_session import Session as Session
from ._label_signals import open_recordings as open_recordings
from ._record import record as record
from ._session import Screen as Screen
from ._session import run_session as run_session
from ._session import so_far as so_far
