"""Registries, base classes and conformance checks for code that extends firstcontact.

A registry maps names to entries, such as contact detectors. Entries come from this package and, by
Python entry points, from other installed packages. The ``check_*`` functions test whether your own
entry behaves as the package expects.

Examples
--------
>>> from firstcontact import plugins
>>> plugins.DETECTORS.default in plugins.DETECTORS.names
True
"""

from firstcontact.contact import DETECTORS, SLIP_DETECTORS, Detector
from firstcontact.core import Registry
from firstcontact.device import SOURCES, Arrival, Descriptor, Source, SourceKind
from firstcontact.device.threaded import ThreadedSource
from firstcontact.export import MODEL_EXPORTERS
from firstcontact.export.registry import ModelExporter
from firstcontact.grasp import HANDS, POLICIES, Hand, HandLimits, Policy
from firstcontact.models import (
    ESTIMATORS,
    Estimator,
    ModelFromArrays,
    Spec,
    Task,
    WindowModel,
    training_spec,
)
from firstcontact.models.windows.window_model import ArrayCheck
from firstcontact.recording import EXPORTERS, IMPORTERS, Exporter, Importer
from firstcontact.streaming import Sink
from firstcontact.streaming.outputs import OUTPUTS, OutputKind
from firstcontact.testing import (
    check_detector,
    check_estimator,
    check_hand,
    check_policy,
    check_source,
)

__all__ = [
    "DETECTORS",
    "ESTIMATORS",
    "EXPORTERS",
    "HANDS",
    "IMPORTERS",
    "MODEL_EXPORTERS",
    "OUTPUTS",
    "POLICIES",
    "SLIP_DETECTORS",
    "SOURCES",
    "ArrayCheck",
    "Arrival",
    "Descriptor",
    "Detector",
    "Estimator",
    "Exporter",
    "Hand",
    "HandLimits",
    "Importer",
    "ModelExporter",
    "ModelFromArrays",
    "OutputKind",
    "Policy",
    "Registry",
    "Sink",
    "Source",
    "SourceKind",
    "Spec",
    "Task",
    "ThreadedSource",
    "WindowModel",
    "check_detector",
    "check_estimator",
    "check_hand",
    "check_policy",
    "check_source",
    "training_spec",
]
