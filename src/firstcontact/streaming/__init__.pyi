"""Streaming: samples in, contacts and estimates out, in real time; the page and other outputs."""

from ._events import Armed as Armed
from ._events import Estimated as Estimated
from ._events import Event as Event
from ._events import PinchDone as PinchDone
from ._events import Refused as Refused
from ._events import Running as Running
from ._events import Settled as Settled
from ._events import Touched as Touched
from ._grasping import Grasping as Grasping
from ._grasping import grasp_lines as grasp_lines
from ._hand_requests import Ask as Ask
from ._json_lines import JsonLinesSink as JsonLinesSink
from ._lsl import LslSink as LslSink
from ._models import ModelWithInterval as ModelWithInterval
from ._pipeline import AFTER as AFTER
from ._pipeline import Pipeline as Pipeline
from ._session import LiveSession as LiveSession
from ._sink import Sink as Sink
from ._summary import ledger_lines as ledger_lines
from ._text import TextSink as TextSink
from .page._sink import PageSink as PageSink
from .page.guard import Guard as Guard
from .page.serving import answer as answer
from .page.serving import listen as listen
from .page.serving import load as load
from .page.serving import serve_page as serve_page
