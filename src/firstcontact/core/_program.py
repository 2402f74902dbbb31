"""Trained models as lists of steps, from which exporters write code in other languages.

A kernel is the C function that carries out a step.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from numpy.typing import NDArray

Constants = Mapping[str, int | float | NDArray[Any]]

#: Name of the input vector of a program: the window, with all channels of each sample.
INPUT = "window"


@dataclass(frozen=True, slots=True, eq=False)
class Step:
    """Computation of one float32 vector from other vectors.

    Parameters
    ----------
    kernel
        Name of the kernel, one of :mod:`firstcontact.core.steps`.
    takes
        Names of the input vectors.
    gives
        Name of the output vector.
    size
        Length of the output vector.
    constants
        Other inputs of the kernel by name: integers, real numbers, and flat arrays of integers or
        float32.
    instructions
        Upper bound on the number of instructions that the step takes on a Cortex-M7. The bound is
        fitted to instruction counts of an emulator over many sizes, and no count exceeds it.
    """

    kernel: str
    takes: tuple[str, ...]
    gives: str
    size: int
    constants: Constants
    instructions: int


@dataclass(frozen=True, slots=True, eq=False)
class Program:
    """Steps that compute a model's output from a window.

    Parameters
    ----------
    inputs
        Number of values in the window.
    steps
        Steps, each after the steps that compute its inputs.
    output
        Name of the output vector. A regression has one value. A classifier has one value per class.
        The class with the largest value wins, in a tie the first.
    spread
        Name of the vector of length one with the prediction's standard deviation, in the unit of
        the prediction; None without one.

    Raises
    ------
    ValueError
        A step uses a vector that does not exist yet, or overwrites an existing vector.
    """

    inputs: int
    steps: tuple[Step, ...]
    output: str
    spread: str | None = None

    def __post_init__(self) -> None:
        computed = {INPUT}
        for step in self.steps:
            if not computed.issuperset(step.takes) or step.gives in computed:
                raise ValueError(
                    f"the step {step.gives!r} uses a vector that no earlier step gives, or gives "
                    "a vector that exists already"
                )
            computed.add(step.gives)
        if not {self.output, self.spread or self.output} <= computed:
            raise ValueError("no step computes the program's output")

    @property
    def instructions(self) -> int:
        """Upper bound on the number of instructions of a prediction on a Cortex-M7, plus 2 %.

        The bound includes the steps, and one check of each value of the window and of the output.
        """
        check_cost = 16 * self.inputs + 14 * self.size(self.output) + 200
        return int(1.02 * (sum(step.instructions for step in self.steps) + check_cost))

    def size(self, name: str) -> int:
        """Return the length of a vector."""
        if name == INPUT:
            return self.inputs
        return next(step.size for step in self.steps if step.gives == name)


@dataclass(frozen=True, slots=True, eq=False)
class Judgement:
    """Description of a detector in C: its kernel, which works sample by sample, and its constants.

    Parameters
    ----------
    kernel
        Name of the kernel.
    constants
        Constants as in a :class:`Step`; arrays may also be of float64.
    sizes
        Array lengths, in samples, that determine the kernel's memory, by their names in C.
    doubles
        Number of 8-byte values that the kernel stores per channel.
    """

    kernel: str
    constants: Constants
    sizes: Mapping[str, int]
    doubles: int
