"""Write docs/reference/python.md: what the rooms of the package offer to others.

python docs/write_api.py
"""

from __future__ import annotations

import re
from importlib import import_module
from pathlib import Path
from types import UnionType
from typing import Any

from firstcontact.core import Registry

PAGE = Path(__file__).parent / "reference" / "python.md"
#: Names that others may rely on, by room. A room shows more, for the other rooms.
PUBLIC = {
    "core": (
        "Block Calibration Channel ChannelKind Command Contact Dataset Finger ForceCurve Group "
        "InputError Label Layout Physical Pinch Role VibrationCalibration VibrationSensor "
        "finger_name fingertip_layout joined"
    ),
    "recording": (
        "EXPORTERS Exporter Header IMPORTERS Importer Marker PinchMark Recording RecordingWriter "
        "export import_path load_dataset read_recording write_dataset"
    ),
    "signal": (
        "AsSent CausalResampler Conditioner ContactWindow ExponentialSmoothing SavitzkyGolay "
        "WindowStream contact_windows lookahead resample resample_dataset samples_in"
    ),
    "contact": (
        "DETECTORS Detector SvmDetector ThresholdDetector WindowDecisions WindowDetector detect "
        "load_detector make_detector save_detector unfitted untrained"
    ),
    "models": (
        "DetectionScores ESTIMATORS Estimator FinalModel Interval LabelledWindows LearnedFrom "
        "ModelCard Provenance Spec Split Task WindowModel by_session classification_scores "
        "labelled_windows leave_one_out load_digests load_interval load_window_model "
        "make_estimator model_folders pinch_digests read_card regression_scores save_model "
        "score_detector train_final_model usable"
    ),
    "twin": "CONDITIONS TwinStream",
    "grasp": "Grip HANDS Hand HandError HandLimits POLICIES Policy Stiffness open_hand",
    "device": "Arrival Descriptor Health SOURCES Source SourceKind open_source",
    "testing": "check_detector check_estimator check_hand check_policy check_source",
}
HEAD = """\
# From Python

Written by `docs/write_api.py` out of the docstrings; a test holds this page against them.

Begin with `import firstcontact as fc`: these functions and types do what the command line does. The
[tutorial](../tutorial/from-python.md) uses them. Rooms hold the parts for those who build on them:
`from firstcontact.contact import detect`. Semantic versioning
promises it: what is taken away or changes its meaning raises the first number of the version (the
second before 1.0). Everything else is the package's own affair and may change at any time.
[Architecture](../explanation/architecture.md) says how the rooms fit, `help(...)` the rest of each.
"""


def said(thing: Any) -> str:
    """The first sentence that something says of itself."""
    if isinstance(thing, Registry):
        return f"All {thing.kind}s by name, those of plug-ins among them."
    if isinstance(thing, dict):
        return f"By name: {', '.join(f'`{name}`' for name in thing)}."
    if isinstance(thing, UnionType):
        return f"One of {', '.join(f'`{kind.__name__}`' for kind in thing.__args__)}."
    first = " ".join((thing.__doc__ or "").strip().split("\n\n")[0].split())
    return re.sub(r":\w+:(?=`)", "", first).replace("``", "`")


def room(name: str) -> str:
    """A table of a room."""
    full = f"firstcontact.{name}" if name else "firstcontact"
    module = import_module(full)
    words = PUBLIC[name].split() if name in PUBLIC else list(module.__all__)
    words += [] if name else ["open"]  # which a star import leaves out
    rows = [f"| `{word}` | {said(getattr(module, word))} |" for word in sorted(words)]
    head = f"## {full}\n\n{said(module)}\n\n| name | |\n|---|---|\n"
    return head + "\n".join(rows) + "\n"


def page() -> str:
    """The page."""
    return "\n".join([HEAD, *map(room, ("", "plugins", *PUBLIC))])


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
