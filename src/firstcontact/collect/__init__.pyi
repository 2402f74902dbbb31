"""Collecting: guided recording, calibration, and the page on which contacts are labelled."""

from ._camera import compare as compare
from ._camera import in_words as in_words
from ._camera import read_contacts as read_contacts
from ._force_fit import Weighing as Weighing
from ._force_fit import fit_force as fit_force
from ._force_fit import read_weights as read_weights
from ._guide import Guide as Guide
from ._guide import Judged as Judged
from ._label_result import By as By
from ._label_server import LabelServer as LabelServer
from ._label_session import Session as Session
from ._label_signals import open_recordings as open_recordings
from ._plan import Item as Item
from ._plan import read_plan as read_plan
from ._session import header_of as header_of
from ._session import run_session as run_session
from ._session import with_noise as with_noise
from ._sessions import so_far as so_far
from ._tap import tap_warnings as tap_warnings
from ._tap import wait_for_tap as wait_for_tap
from ._weigh import loaded_volts as loaded_volts
