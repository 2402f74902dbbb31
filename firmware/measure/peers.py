"""Other implementations in the same emulator for comparison: plain C and CMSIS-DSP."""

from __future__ import annotations

from pathlib import Path
from textwrap import fill

import building
import numpy as np
from numpy.typing import NDArray

from firstcontact.models.windows.svm import LEVEL_WEIGHT, SvmModel, shape_and_level


def plain(model: SvmModel, X: NDArray[np.float32], folder: Path, cmsis: Path | None) -> int:
    """Return the instructions of one prediction with plain C or with CMSIS-DSP's sources."""
    folder.mkdir(parents=True)
    a = model.to_arrays()
    numbers = {
        "PLAIN_VECTORS": len(a["vectors"]),
        "PLAIN_INPUTS": a["vectors"].shape[1],
        "PLAIN_BIAS": np.float32(a["bias"][0]),
        "PLAIN_MEAN": np.float32(a["level"][0]),
        "PLAIN_SLOPE": np.float32(LEVEL_WEIGHT / a["level"][1]),
        "PLAIN_GAMMA": np.float32(a["parameters"][1]),
    }
    text = "".join(f"#define {name} {_literal(value)}\n" for name, value in numbers.items())
    text += _array("plain_vectors", a["vectors"]) + _array("plain_weights", a["weights"][0])
    (folder / "plain_svm_model.h").write_text(text, encoding="utf-8")
    definitions: dict[str, str] = {}
    more: list[str] = []
    if cmsis is not None:
        definitions |= {"CMSIS": "1", "__GNUC_PYTHON__": "1"}
        source = cmsis / "Source" / "SVMFunctions"
        more += [str(source / f"arm_svm_rbf_{part}_f32.c") for part in ("init", "predict")]
        more += [f"-isystem{cmsis / name}" for name in ("Include", "PrivateInclude")]
        more += ["-Wno-error", "-w"]
    image = building.Program("plain_svm.c", folder, definitions, more).m7(folder / "plain.elf")
    counts = np.frombuffer(building.ask_m7(image, X[:5].tobytes(), folder), np.uint32)
    return int(counts.max())


def _literal(value: np.float32 | int) -> str:
    """Return a C literal that reads back as the same number."""
    return str(value) if isinstance(value, int) else f"{float(value):.9e}f"


def _array(name: str, values: NDArray[np.float64]) -> str:
    """Return the C definition of a constant array."""
    numbers = fill(", ".join(map(_literal, np.float32(values.ravel()))), break_long_words=False)
    return f"static const float {name}[{values.size}] = {{\n{numbers}}};\n"


def oracle(model: SvmModel, X: NDArray[np.float32]) -> dict[str, int] | None:
    """Compare the sign of the model's output with the package cmsisdsp on this machine.

    Its support vector machine predicts two classes only. Return None if it is not installed.
    """
    try:
        import cmsisdsp
    except ImportError:
        return None
    a = model.to_arrays()
    vectors = a["vectors"].astype(np.float32)
    machine = cmsisdsp.arm_svm_rbf_instance_f32()
    cmsisdsp.arm_svm_rbf_init_f32(
        machine, *vectors.shape, float(a["bias"][0]), a["weights"][0].astype(np.float32),
        vectors.ravel(), np.array([0, 1], np.int32), float(a["parameters"][1]),
    )  # fmt: skip
    inputs = shape_and_level(X, a["level"]).astype(np.float32)
    sides = [int(cmsisdsp.arm_svm_rbf_predict_f32(machine, x)) for x in inputs]
    wanted = model.outputs(X)[:, 0] > 0
    return {"asked": len(X), "other_sides": int((np.array(sides) != wanted).sum())}


def of_cmsis(
    model: SvmModel, X: NDArray[np.float32], folder: Path, sources: Path | None
) -> dict[str, dict[str, int]]:
    """Return a row for CMSIS-DSP: its cost and the number of other results.

    Parts that are not installed are skipped with a message.
    """
    name = f"CMSIS-DSP arm_svm_rbf_predict_f32, {model.notes['support_vectors']} vectors"
    row: dict[str, int] = {}
    if sources is None:
        print(f"skipped: instructions of {name} (no --cmsis)")
    else:
        row["instructions"] = plain(model, X, folder, sources)
    comparison = oracle(model, X)
    if comparison is None:
        print(f"skipped: predictions of {name} (the package cmsisdsp is not installed)")
    else:
        row |= comparison
    return {name: row} if row else {}
