"""The shape of the network, once: PyTorch learns it, ONNX runs it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Stage:
    """Blocks of one kind.

    Parameters
    ----------
    fused
        Fused-MBConv (one wide convolution in place of expansion and depthwise)
        or MBConv with squeeze-excitation.
    expand
        How much wider the block is inside.
    channels
        What it puts out.
    stride
        Of the first block; the others keep the length.
    blocks
        How many.
    """

    fused: bool
    expand: int
    channels: int
    stride: int
    blocks: int


@dataclass(frozen=True, slots=True)
class Block:
    """One block of a stage, with the channels that come in."""

    fused: bool
    inputs: int
    wide: int
    outputs: int
    stride: int

    @property
    def squeezed(self) -> int:
        """Width of the squeeze: a quarter of the block's input, as published."""
        return max(1, self.inputs // 4)

    @property
    def shortcut(self) -> bool:
        """Whether what comes in is added to what goes out."""
        return self.stride == 1 and self.inputs == self.outputs


#: Samples that every convolution sees.
KERNEL = 3
STEM_KERNEL = 5
STEM = 16
STEM_STRIDE = 2
#: EfficientNetV2 (Tan and Le 2021, table 4) made small: Fused-MBConv first,
#: MBConv with squeeze-excitation where the signal has become short.
STAGES = (
    Stage(fused=True, expand=1, channels=16, stride=2, blocks=1),
    Stage(fused=True, expand=4, channels=24, stride=2, blocks=1),
    Stage(fused=False, expand=4, channels=48, stride=2, blocks=2),
)
HEAD = 96


def blocks() -> Iterator[Block]:
    """All blocks in their order."""
    inputs = STEM
    for stage in STAGES:
        for number in range(stage.blocks):
            stride = stage.stride if number == 0 else 1
            yield Block(stage.fused, inputs, stage.expand * inputs, stage.channels, stride)
            inputs = stage.channels
