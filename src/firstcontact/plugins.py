"""Registries, base classes and conformance checks for code that extends firstcontact.

A registry maps names to entries: those of this package, and those that installed packages add by
entry points. ``check_*`` functions test an entry of your own against what its users rely on.
"""

from firstcontact.contact import DETECTORS, SLIP_DETECTORS, Detector, WindowDetector
from firstcontact.core import Registry
from firstcontact.device import (
    SOURCES,
    Arrival,
    Descriptor,
    Source,
    SourceKind,
    ThreadedSource,
)
from firstcontact.export import MODEL_EXPORTERS, ModelExporter
from firstcontact.grasp import HANDS, POLICIES, Hand, HandLimits, Policy
from firstcontact.models import (
    ESTIMATORS,
    ArraysModel,
    Estimator,
    Spec,
    Task,
    WindowModel,
    training_spec,
)
from firstcontact.recording import EXPORTERS, IMPORTERS, Exporter, Importer
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
    "POLICIES",
    "SLIP_DETECTORS",
    "SOURCES",
    "ArraysModel",
    "Arrival",
    "Descriptor",
    "Detector",
    "Estimator",
    "Exporter",
    "Hand",
    "HandLimits",
    "Importer",
    "ModelExporter",
    "Policy",
    "Registry",
    "Source",
    "SourceKind",
    "Spec",
    "Task",
    "ThreadedSource",
    "WindowDetector",
    "WindowModel",
    "check_detector",
    "check_estimator",
    "check_hand",
    "check_policy",
    "check_source",
    "training_spec",
]
