"""EfficientNetV2 for one dimension: definition and joint training. This module imports PyTorch.

Mingxing Tan and Quoc V. Le: EfficientNetV2: Smaller Models and Faster Training, ICML 2021
(arXiv:2104.00298).

The network has two dimensions, time and one of length one, because PyTorch has channels-last
kernels for two dimensions only. With these kernels, training takes two thirds of the time that it
takes without them.
"""

from __future__ import annotations

from collections.abc import Sequence
from copy import deepcopy
from dataclasses import dataclass
from typing import Self

import torch
from torch import Tensor, nn
from torch.nn.utils import fuse_conv_bn_eval

#: Number of samples that every convolution covers.
KERNEL = 3
STEM_KERNEL = 5
STEM = 16
STEM_STRIDE = 2
HEAD = 96


@dataclass(frozen=True, slots=True)
class Stage:
    """Stage of an EfficientNetV2: a number of equal ``blocks`` (groups of layers) in sequence."""

    fused: bool
    expand: int
    channels: int
    stride: int
    blocks: int


#: Reduced EfficientNetV2 (Tan and Le 2021, table 4): Fused-MBConv first, then MBConv with
#: squeeze-excitation for the shortened signal.
STAGES = (
    Stage(fused=True, expand=1, channels=16, stride=2, blocks=1),
    Stage(fused=True, expand=4, channels=24, stride=2, blocks=1),
    Stage(fused=False, expand=4, channels=48, stride=2, blocks=2),
)


class ConvNorm(nn.Sequential):
    """Convolution, then batch normalisation, then the activation SiLU unless ``linear``."""

    def __init__(
        self,
        inputs: int,
        outputs: int,
        kernel: int,
        stride: int = 1,
        groups: int = 1,
        linear: bool = False,
    ) -> None:
        conv = nn.Conv2d(
            inputs, outputs, (1, kernel), (1, stride), (0, kernel // 2), groups=groups, bias=False
        )
        super().__init__(conv, nn.BatchNorm2d(outputs))
        if not linear:
            self.append(nn.SiLU(inplace=True))

    def fold(self) -> None:
        """Move the normalisation into the weights of the convolution, for faster predictions."""
        conv, norm = self[0], self[1]
        assert isinstance(conv, nn.Conv2d)
        assert isinstance(norm, nn.BatchNorm2d)
        self[0], self[1] = fuse_conv_bn_eval(conv, norm), nn.Identity()


class SqueezeExcitation(nn.Module):
    """Squeeze-excitation: weights for the channels, computed from their means over time."""

    def __init__(self, channels: int, squeezed: int) -> None:
        super().__init__()
        self.squeeze = nn.Linear(channels, squeezed)
        self.excite = nn.Linear(squeezed, channels)

    def forward(self, x: Tensor) -> Tensor:
        """Return the block's output; input and output have the shape (n, channels, 1, samples)."""
        pooled = nn.functional.silu(self.squeeze(x.mean(dim=(2, 3))))
        return x * torch.sigmoid(self.excite(pooled))[:, :, None, None]


class MBConv(nn.Module):
    """Block of a stage: Fused-MBConv, or MBConv with squeeze-excitation."""

    def __init__(self, stage: Stage, inputs: int, stride: int) -> None:
        super().__init__()
        outputs, wide = stage.channels, stage.expand * inputs
        self.shortcut = stride == 1 and inputs == outputs
        if stage.fused and wide == inputs:
            layers: list[nn.Module] = [ConvNorm(inputs, outputs, KERNEL, stride)]
        elif stage.fused:
            layers = [
                ConvNorm(inputs, wide, KERNEL, stride),
                ConvNorm(wide, outputs, 1, linear=True),
            ]
        else:
            layers = [
                ConvNorm(inputs, wide, 1),
                ConvNorm(wide, wide, KERNEL, stride, groups=wide),
                # A quarter of the block's input, as published.
                SqueezeExcitation(wide, max(1, inputs // 4)),
                ConvNorm(wide, outputs, 1, linear=True),
            ]
        self.layers = nn.Sequential(*layers)

    def forward(self, x: Tensor) -> Tensor:
        """Return the block's output; input and output have the shape (n, channels, 1, samples)."""
        out: Tensor = self.layers(x)
        return x + out if self.shortcut else out


class EfficientNet(nn.Module):
    """EfficientNetV2: stem, stages, head, mean over time, and one linear layer."""

    def __init__(self, channels: int, outputs: int) -> None:
        super().__init__()
        self.channels = channels
        self.stem = ConvNorm(channels, STEM, STEM_KERNEL, STEM_STRIDE)
        blocks, inputs = [], STEM
        for stage in STAGES:
            for number in range(stage.blocks):
                blocks.append(MBConv(stage, inputs, stage.stride if number == 0 else 1))
                inputs = stage.channels
        self.blocks = nn.Sequential(*blocks)
        self.head = ConvNorm(inputs, HEAD, 1)
        self.last = nn.Linear(HEAD, outputs)

    def forward(self, x: Tensor) -> Tensor:
        """Return the outputs (n, outputs) for windows (n, channels, 1, samples)."""
        out: Tensor = self.last(self.head(self.blocks(self.stem(x))).mean(dim=(2, 3)))
        return out

    def folded(self) -> Self:
        """Return a copy for predictions, with normalisations folded into convolutions."""
        copy = deepcopy(self).eval()
        for module in list(copy.modules()):
            if isinstance(module, ConvNorm):
                module.fold()
        return copy


class GroupedLinear(nn.Module):
    """Linear layers of several networks, computed as one layer for :func:`join`."""

    def __init__(self, layers: Sequence[nn.Linear]) -> None:
        super().__init__()
        self.copies = len(layers)
        self.weight = _joined([layer.weight for layer in layers])
        self.bias = _joined([layer.bias for layer in layers])

    def forward(self, x: Tensor) -> Tensor:
        """Map inputs of shape (n, copies * inputs) to outputs of shape (n, copies * outputs)."""
        parts = x.reshape(len(x), self.copies, -1).transpose(0, 1)
        weight = self.weight.view(self.copies, -1, parts.shape[2]).transpose(1, 2)
        out = torch.baddbmm(self.bias.view(self.copies, 1, -1), parts, weight)
        return out.transpose(0, 1).flatten(1)


def join(networks: Sequence[EfficientNet]) -> EfficientNet:
    """Return one network that computes several networks of equal structure side by side.

    Inputs and outputs of the networks are concatenated along the channels.
    """
    joined = deepcopy(networks[0])
    for name, module in list(joined.named_modules()):
        same = [network.get_submodule(name) for network in networks]
        if isinstance(module, nn.Linear):
            joined.set_submodule(name, GroupedLinear(same))  # type: ignore[arg-type]
        elif isinstance(module, nn.Conv2d):
            module.groups *= len(networks)
        elif isinstance(module, nn.BatchNorm2d):
            module.running_mean = torch.cat([m.running_mean for m in same])  # type: ignore[misc]
            module.running_var = torch.cat([m.running_var for m in same])  # type: ignore[misc]
        if isinstance(module, nn.Conv2d | nn.BatchNorm2d):
            for key, _ in list(module.named_parameters()):
                setattr(module, key, _joined([getattr(m, key) for m in same]))
    return joined


def separate(joined: EfficientNet, networks: Sequence[EfficientNet]) -> None:
    """Copy the weights of a network that :func:`join` made back into the single ``networks``."""
    for name, tensor in joined.state_dict().items():
        parts = tensor.chunk(len(networks)) if tensor.ndim else [tensor] * len(networks)
        for network, part in zip(networks, parts, strict=True):
            network.state_dict()[name].copy_(part)


def _joined(parameters: Sequence[Tensor]) -> nn.Parameter:
    return nn.Parameter(torch.cat([parameter.detach() for parameter in parameters]))
