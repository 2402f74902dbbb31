"""EfficientNetV2 for one dimension, as PyTorch trains it.

Mingxing Tan and Quoc V. Le: EfficientNetV2: Smaller Models and Faster
Training, ICML 2021 (arXiv:2104.00298). Importing this module imports PyTorch.

Time is the second of two dimensions, the first has length one: PyTorch's
convolutions and normalisation have a channels-last form for two dimensions
only, and with it an epoch of these short windows takes two thirds of the time.
"""

from __future__ import annotations

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn

from firstcontact.stiffness import architecture
from firstcontact.stiffness.architecture import Block


class ConvNorm(nn.Sequential):
    """Convolution, batch normalisation and (unless ``linear``) SiLU."""

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
            inputs,
            outputs,
            (1, kernel),
            (1, stride),
            (0, kernel // 2),
            groups=groups,
            bias=False,
        )
        super().__init__(conv, nn.BatchNorm2d(outputs))
        if not linear:
            self.append(nn.SiLU(inplace=True))

    def folded(self) -> tuple[Tensor, Tensor]:
        """The convolution with the normalisation multiplied in: weight and bias.

        Weight (outputs, inputs / groups, 1, kernel), bias (outputs,).
        """
        conv, norm = self[0], self[1]
        assert isinstance(conv, nn.Conv2d)
        assert isinstance(norm, nn.BatchNorm2d)
        assert norm.running_mean is not None
        assert norm.running_var is not None
        gain = norm.weight / torch.sqrt(norm.running_var + norm.eps)
        return conv.weight * gain[:, None, None, None], norm.bias - norm.running_mean * gain


class SqueezeExcitation(nn.Module):
    """Weighs channels by what the whole window holds of each."""

    def __init__(self, channels: int, squeezed: int) -> None:
        super().__init__()
        self.squeeze = nn.Linear(channels, squeezed)
        self.excite = nn.Linear(squeezed, channels)

    def forward(self, x: Tensor) -> Tensor:
        """Shape (n, channels, 1, samples) in and out."""
        pooled = nn.functional.silu(self.squeeze(x.mean(dim=(2, 3))))
        return x * torch.sigmoid(self.excite(pooled))[:, :, None, None]


class MBConv(nn.Module):
    """Fused-MBConv, or MBConv with squeeze-excitation."""

    def __init__(self, block: Block) -> None:
        super().__init__()
        self.shortcut = block.shortcut
        k = architecture.KERNEL
        if block.fused and block.wide == block.inputs:
            layers: list[nn.Module] = [ConvNorm(block.inputs, block.outputs, k, block.stride)]
        elif block.fused:
            layers = [
                ConvNorm(block.inputs, block.wide, k, block.stride),
                ConvNorm(block.wide, block.outputs, 1, linear=True),
            ]
        else:
            layers = [
                ConvNorm(block.inputs, block.wide, 1),
                ConvNorm(block.wide, block.wide, k, block.stride, groups=block.wide),
                SqueezeExcitation(block.wide, block.squeezed),
                ConvNorm(block.wide, block.outputs, 1, linear=True),
            ]
        self.layers = nn.Sequential(*layers)

    def forward(self, x: Tensor) -> Tensor:
        """Shape (n, channels, 1, samples) in and out."""
        out: Tensor = self.layers(x)
        return x + out if self.shortcut else out


class EfficientNet(nn.Module):
    """Stem, stages, head, mean over time, and one linear layer.

    Parameters
    ----------
    channels
        Channels of a window.
    outputs
        1 for regression, otherwise the number of classes.
    """

    def __init__(self, channels: int, outputs: int) -> None:
        super().__init__()
        self.stem = ConvNorm(
            channels, architecture.STEM, architecture.STEM_KERNEL, architecture.STEM_STRIDE
        )
        self.blocks = nn.Sequential(*(MBConv(block) for block in architecture.blocks()))
        self.head = ConvNorm(architecture.STAGES[-1].channels, architecture.HEAD, 1)
        self.last = nn.Linear(architecture.HEAD, outputs)

    def forward(self, x: Tensor) -> Tensor:
        """Windows (n, channels, 1, samples) to answers (n, outputs)."""
        out: Tensor = self.last(self.head(self.blocks(self.stem(x))).mean(dim=(2, 3)))
        return out

    def weights(self) -> dict[str, NDArray[np.float32]]:
        """All weights after training, normalisations folded into their convolutions.

        Named after the module that holds them, as :func:`graph.build` reads them.
        """
        out: dict[str, Tensor] = {}
        for name, module in self.named_modules():
            if isinstance(module, ConvNorm):
                out[f"{name}.weight"], out[f"{name}.bias"] = module.folded()
            elif isinstance(module, nn.Linear):
                out[f"{name}.weight"], out[f"{name}.bias"] = module.weight, module.bias
        return {name: tensor.detach().contiguous().numpy() for name, tensor in out.items()}
