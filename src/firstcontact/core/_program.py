"""What a trained model computes, as a list of steps that other languages can be written from."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from numpy.typing import NDArray

Constants = Mapping[str, int | float | NDArray[Any]]

#: Name of the vector that a program begins with: the window, all channels of each sample.
INPUT = "window"


@dataclass(frozen=True, slots=True, eq=False)
class Step:
    """One vector of float32 computed from others.

    Parameters
    ----------
    kernel
        What computes it: one of :mod:`firstcontact.core.steps`.
    takes
        Names of vectors that are there already.
    gives
        Name of the vector that it makes.
    size
        Length of that.
    constants
        What the kernel is given beside vectors, by name: whole numbers, real numbers, and flat
        arrays of integers or float32.
    instructions
        How many a Cortex-M7 runs for it at most: fitted to counts of the emulator, over sizes, and
        not below any of them, so that a budget is kept.
    """

    kernel: str
    takes: tuple[str, ...]
    gives: str
    size: int
    constants: Constants
    instructions: int


@dataclass(frozen=True, slots=True, eq=False)
class Program:
    """Steps from a window to what a model puts out.

    Parameters
    ----------
    inputs
        Numbers in the window.
    steps
        In an order in which each finds what it takes.
    output
        Name of the vector of outputs: one for a regression, else one a class, of which the
        first largest is chosen.
    spread
        Name of the vector of one that holds the standard deviation of the answer, in the
        unit of the answer; None where there is none.

    Raises
    ------
    ValueError
        A step that takes what is not there, or gives what is.
    """

    inputs: int
    steps: tuple[Step, ...]
    output: str
    spread: str | None = None

    def __post_init__(self) -> None:
        known = {INPUT}
        for step in self.steps:
            if not known.issuperset(step.takes) or step.gives in known:
                raise ValueError(f"the step {step.gives!r} does not follow those before it")
            known.add(step.gives)
        if not {self.output, self.spread or self.output} <= known:
            raise ValueError("the program does not give its output")

    @property
    def instructions(self) -> int:
        """How many a Cortex-M7 runs for one answer at most; two hundredths are kept in reserve.

        Beside the steps each number of the window and of the output is looked at, for what is
        refused and what is chosen.
        """
        looked = 16 * self.inputs + 14 * self.size(self.output) + 200
        return int(1.02 * (sum(step.instructions for step in self.steps) + looked))

    def size(self, name: str) -> int:
        """Length of a vector."""
        if name == INPUT:
            return self.inputs
        return next(step.size for step in self.steps if step.gives == name)


@dataclass(frozen=True, slots=True, eq=False)
class Judgement:
    """How a detector judges windows, as a kernel that is fed sample by sample.

    Parameters
    ----------
    kernel
        Name of the kernel.
    constants
        As of a :class:`Step`, arrays of float64 among them.
    sizes
        Lengths in samples that its memory depends on, by the names that the kernel has for them.
    doubles
        Numbers of 8 bytes that it keeps of each channel.
    """

    kernel: str
    constants: Constants
    sizes: Mapping[str, int]
    doubles: int
