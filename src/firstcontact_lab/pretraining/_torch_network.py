"""Full network in PyTorch, with attention to the rig's levels of Shore A."""

from __future__ import annotations

import torch
from torch import nn

from firstcontact.chain import INPUTS
from firstcontact.models import COMPONENTS, FARTHEST, GENERAL, TOKEN

#: Number of attention heads.
HEADS = 4
#: Scale of the outputs: Shore A is CENTRE + UNIT times an output.
CENTRE, UNIT = 40.0, 40.0
#: Bounds of ln(standard deviation / UNIT), and the scale of the means at the start of training.
SPREAD, MEAN_SCALE = (-4.0, 2.0), 0.6
#: Widths of the layers for a token, the context, the body, and the last layer of the body.
TOKENS, CONTEXT, BODY, LAST = 96, 64, 256, 128
_KEYS = 16 * HEADS


class TorchNetwork(nn.Module):
    """Full network."""

    def __init__(self) -> None:
        super().__init__()
        sizes = {
            "token1": (TOKEN, TOKENS),
            "token2": (TOKENS, TOKENS),
            "mean": (TOKENS, CONTEXT),
            "key": (TOKENS, _KEYS),
            "value": (TOKENS, CONTEXT),
            "query1": (INPUTS, BODY),
            "query2": (BODY, _KEYS),
            "body1": (BODY + 2 * CONTEXT + GENERAL, BODY),
            "body2": (BODY, BODY),
            "body3": (BODY, LAST),
            "answer": (LAST, 3 * COMPONENTS),
        }
        self.layers = nn.ModuleDict({name: nn.Linear(*size) for name, size in sizes.items()})

    def forward(
        self,
        x: torch.Tensor,
        tokens: torch.Tensor,
        present: torch.Tensor,
        general: torch.Tensor,
    ) -> tuple[torch.Tensor, torch.Tensor, torch.Tensor]:
        """Return a mixture of normal distributions for each contact. Rigs may differ."""
        return self.predict(x, self.encoded(tokens), present, general)

    def encoded(self, tokens: torch.Tensor) -> torch.Tensor:
        """Return the encoding of each token, shape (n, levels, TOKENS)."""
        silu, layers = nn.functional.silu, self.layers
        return silu(layers["token2"](silu(layers["token1"](tokens.clamp(-FARTHEST, FARTHEST)))))

    def predict(
        self, x: torch.Tensor, e: torch.Tensor, present: torch.Tensor, general: torch.Tensor
    ) -> tuple[torch.Tensor, torch.Tensor, torch.Tensor]:
        """Return :meth:`forward` for encoded tokens ``e``."""
        silu, layers, n = nn.functional.silu, self.layers, len(x)
        count = present.sum(1, keepdim=True).clamp(min=1)
        mean = (layers["mean"](e) * present[..., None]).sum(1) / count
        h = silu(layers["query1"](x.clamp(-FARTHEST, FARTHEST)))
        query = layers["query2"](h).view(n, HEADS, 1, -1)
        keys = layers["key"](e).view(n, -1, HEADS, query.shape[-1]).transpose(1, 2)
        values = layers["value"](e).view(n, keys.shape[2], HEADS, -1).transpose(1, 2)
        fit = (query * keys).sum(-1) / query.shape[-1] ** 0.5
        share = torch.softmax(fit - 1e4 * (1 - present[:, None, :]), dim=-1) * present[:, None, :]
        attended = (share[..., None] * values).sum(2).reshape(n, -1)
        # Without levels the mean is zero, so that the bias of its layer has no effect.
        any_ = (present.sum(1, keepdim=True) > 0).float()
        body = torch.cat([h, mean * any_, attended, general.clamp(-FARTHEST, FARTHEST)], 1)
        for name in ("body1", "body2", "body3"):
            body = silu(layers[name](body))
        weight, centre, spread = layers["answer"](body).chunk(3, dim=1)
        return torch.log_softmax(weight, 1), MEAN_SCALE * centre, spread.clamp(*SPREAD)
