"""Registries, base classes and conformance checks for code that extends firstcontact.

A registry maps names to entries. Entries come from this package and, by entry points, from other
installed packages. The ``check_*`` functions test whether your own entry behaves as the package
expects.

Examples
--------
Registries:

>>> from firstcontact import plugins
>>> plugins.DETECTORS.default in plugins.DETECTORS.names
True
>>> registries = [plugins.ESTIMATORS, plugins.POLICIES, plugins.HANDS, plugins.SOURCES]
>>> registries += [plugins.IMPORTERS, plugins.EXPORTERS, plugins.MODEL_EXPORTERS]
>>> registries += [plugins.SLIP_DETECTORS]
>>> all(isinstance(registry, plugins.Registry) for registry in registries)
True

A detector:

>>> import numpy as np
>>> class Energy(plugins.Detector):
...     name = "energy"
...
...     def fires(self, windows):
...         newest = windows[:, :, -windows.shape[2] * 3 // 20 :]
...         return np.mean(newest**2, axis=2) > 6.0
>>> kind: type[plugins.Detector] = Energy
>>> plugins.check_detector(kind)

An estimator and its model, whose constructor takes a spec and arrays:

>>> from dataclasses import dataclass
>>> class LoudnessModel(plugins.ArraysModel):
...     kind = "loudness"
...     declared = {"line": plugins.ArrayCheck((2,)), "target": plugins.ArrayCheck((2,), 1)}
...     notes = {}
...
...     def outputs(self, X):
...         loudness = np.log(X.astype(float).std(axis=(1, 2)))
...         return np.polyval(self._arrays["line"], loudness)[:, None]
>>> @dataclass(frozen=True)
... class Loudness(plugins.Estimator):
...     name = "loudness"
...     title = "Loudness alone"
...     model = LoudnessModel
...     tasks = (plugins.Task.REGRESSION,)
...
...     def fit(self, X, y, groups=None, seed=0):
...         spec: plugins.Spec = plugins.training_spec(self.task, self.rate, X, y, groups)
...         loudness = np.log(X.astype(float).std(axis=(1, 2)))
...         return LoudnessModel(spec, np.polyfit(loudness, y, 1), np.array([0.0, 1.0]))
>>> issubclass(LoudnessModel, plugins.WindowModel)
True
>>> plugins.check_estimator(Loudness)

A policy:

>>> from firstcontact.core import Command
>>> class Halfway(plugins.Policy):
...     name = "halfway"
...     title = "half as gentle"
...
...     def touched(self, contact, first):
...         gentle = self.grip.gentle
...         return Command((gentle.speed + self.grip.speed) / 2, gentle.force)
>>> plugins.check_policy(Halfway)

A hand:

>>> from firstcontact.grasp import HandError
>>> class Silent(plugins.Hand):
...     name = "silent"
...     limits = plugins.HandLimits(speed=0.1, force=8.0, rate=50.0, watchdog=float("inf"))
...     simulated_port = "nowhere"
...
...     def __init__(self, port=None):
...         self.is_open = False
...
...     def send(self, command):
...         if not self.is_open:
...             raise HandError("it is not open")
...
...     def release(self): ...
...
...     def close(self):
...         self.is_open = False
...
...     def __enter__(self):
...         self.is_open = True
...         return self
>>> plugins.check_hand(Silent)

A source. ``ThreadedSource`` is the base of sources that a thread reads:

>>> from pathlib import Path
>>> from firstcontact.device.replay import ReplaySource
>>> reel = plugins.SourceKind(
...     "reel",
...     "reel:PATH for a recording",
...     lambda device, options: ReplaySource(Path(device.removeprefix("reel:")), options.speed),
...     recorded=True,
... )
>>> plugins.check_source(reel, "reel:recordings/blocks-01.mcap")
>>> with ReplaySource(Path("recordings/blocks-01.mcap"), float("inf")) as source:
...     descriptor: plugins.Descriptor = source.descriptor
...     arrivals: list[plugins.Arrival] = source.read(1.0)
>>> kind: type[plugins.Source] = plugins.ThreadedSource
>>> len(arrivals) > 0
True

Formats of pinches and of models:

>>> def write(data, path):
...     np.save(path, data.shore_a)
>>> labels = plugins.Exporter("labels", write)
>>> def read(path, rate):
...     raise NotImplementedError
>>> importer = plugins.Importer("labels", "a .labels file", read, suffixes=(".labels",))
>>> importer.accepts(Path("a.labels"))
True
>>> model_exporter = plugins.ModelExporter("nothing", lambda model, folder: ["nothing written"])
"""

from firstcontact.contact import DETECTORS, SLIP_DETECTORS, Detector
from firstcontact.core import Registry
from firstcontact.device import SOURCES, Arrival, Descriptor, Source, SourceKind
from firstcontact.device.threaded import ThreadedSource
from firstcontact.export import MODEL_EXPORTERS
from firstcontact.export.parts import ModelExporter
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
from firstcontact.models.window_model import ArrayCheck
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
    "ArrayCheck",
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
    "WindowModel",
    "check_detector",
    "check_estimator",
    "check_hand",
    "check_policy",
    "check_source",
    "training_spec",
]
