"""Uncompressed network in PyTorch, and its training, which can be stopped and resumed."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import torch
from numpy.typing import NDArray
from torch import nn

from firstcontact.chain.touch import INPUTS
from firstcontact.core.files import replacing
from firstcontact.models.rig.context_network import ContextNetwork
from firstcontact.models.rig.rigs import Rig
from firstcontact_lab.pretraining.batches import draw_batch, token_rows
from firstcontact_lab.pretraining.examples import Examples

_FARTHEST = ContextNetwork.FARTHEST

HEADS = 4
#: Scale of the outputs: Shore A is CENTRE + UNIT times an output.
CENTRE, UNIT = 40.0, 40.0
#: Bounds of ln(standard deviation / UNIT), and the scale of the means at the start of training.
SPREAD, MEAN_SCALE = (-4.0, 2.0), 0.6
#: Widths of the layers for a token, the context, the body, and the last layer of the body.
TOKENS, CONTEXT, BODY, LAST = 96, 64, 256, 128
_KEYS = 16 * HEADS


class TorchNetwork(nn.Module):
    def __init__(self) -> None:
        super().__init__()
        sizes = {
            "token1": (Rig.TOKEN, TOKENS),
            "token2": (TOKENS, TOKENS),
            "mean": (TOKENS, CONTEXT),
            "key": (TOKENS, _KEYS),
            "value": (TOKENS, CONTEXT),
            "query1": (INPUTS, BODY),
            "query2": (BODY, _KEYS),
            "body1": (BODY + 2 * CONTEXT + Rig.GENERAL, BODY),
            "body2": (BODY, BODY),
            "body3": (BODY, LAST),
            "answer": (LAST, 3 * ContextNetwork.COMPONENTS),
        }
        self.layers = nn.ModuleDict({name: nn.Linear(*size) for name, size in sizes.items()})

    def forward(
        self, x: torch.Tensor, tokens: torch.Tensor, present: torch.Tensor, general: torch.Tensor
    ) -> tuple[torch.Tensor, torch.Tensor, torch.Tensor]:
        """Return the scaled Shore A of each contact as a mixture of normal distributions.

        The result is (logarithms of the weights, means, logarithms of the standard deviations).
        """
        return self.predict(x, self.encoded(tokens), present, general)

    def encoded(self, tokens: torch.Tensor) -> torch.Tensor:
        silu, layers = nn.functional.silu, self.layers
        return silu(layers["token2"](silu(layers["token1"](tokens.clamp(-_FARTHEST, _FARTHEST)))))

    def predict(
        self, x: torch.Tensor, e: torch.Tensor, present: torch.Tensor, general: torch.Tensor
    ) -> tuple[torch.Tensor, torch.Tensor, torch.Tensor]:
        """Return the same mixtures as :meth:`forward`, from blocks ``e`` already encoded."""
        silu, layers, n = nn.functional.silu, self.layers, len(x)
        count = present.sum(1, keepdim=True).clamp(min=1)
        mean = (layers["mean"](e) * present[..., None]).sum(1) / count
        h = silu(layers["query1"](x.clamp(-_FARTHEST, _FARTHEST)))
        query = layers["query2"](h).view(n, HEADS, 1, -1)
        keys = layers["key"](e).view(n, -1, HEADS, query.shape[-1]).transpose(1, 2)
        values = layers["value"](e).view(n, keys.shape[2], HEADS, -1).transpose(1, 2)
        fit = (query * keys).sum(-1) / query.shape[-1] ** 0.5
        share = torch.softmax(fit - 1e4 * (1 - present[:, None, :]), dim=-1) * present[:, None, :]
        attended = (share[..., None] * values).sum(2).reshape(n, -1)
        # Without levels the mean is zero, so that the bias of its layer has no effect.
        any_ = (present.sum(1, keepdim=True) > 0).float()
        body = torch.cat([h, mean * any_, attended, general.clamp(-_FARTHEST, _FARTHEST)], 1)
        for name in ("body1", "body2", "body3"):
            body = silu(layers[name](body))
        weight, centre, spread = layers["answer"](body).chunk(3, dim=1)
        return torch.log_softmax(weight, 1), MEAN_SCALE * centre, spread.clamp(*SPREAD)


#: Number of contacts in a training step, and number of contacts that are prepared together.
BATCH, PREPARED = 512, 16_384
#: Largest learning rate, the share of the training in which it rises, and weight decay.
RATE, WARM_UP, DECAY = 2e-3, 0.15, 2e-2
#: Weight of the squared error beside the likelihood.
SQUARED = 2.0

Lot = tuple[torch.Tensor, ...]


@dataclass(frozen=True, slots=True, eq=False)
class Full:
    network: TorchNetwork
    scales: Mapping[str, NDArray[np.float32]]

    def scaled(self, name: str, x: NDArray[np.float32]) -> NDArray[np.float32]:
        """Return inputs of the network minus their mean, divided by their standard deviation.

        ``name`` is the name of the input.
        """
        out: NDArray[np.float32] = (x - self.scales[f"{name}.mean"]) / self.scales[f"{name}.sd"]
        return out


class Training:
    """Training of an uncompressed network. It is saved after each epoch, and can be resumed."""

    def __init__(self, examples: Examples, epochs: int, seed: int, state: Path) -> None:
        torch.manual_seed(seed)
        self._examples, self._epochs, self._seed, self._state = examples, epochs, seed, state
        self._network = TorchNetwork()
        self._full = Full(self._network, input_scales(examples, seed))
        self._optimizer = torch.optim.AdamW(self._network.parameters(), RATE, weight_decay=DECAY)
        self._done = 0  # number of complete epochs
        tokens, present = token_rows(examples)
        scaled = self._full.scaled("token", tokens) * present[..., None]
        self._tokens, self._there = torch.from_numpy(scaled), torch.from_numpy(present)
        if state.exists():
            self._load_state()

    def run(self, progress: Callable[[int, float], object] = lambda epoch, loss: None) -> Full:
        """Run the remaining epochs, and return the network.

        After each epoch, call ``progress`` with the number of the epoch and the mean loss.
        """
        for epoch in range(self._done, self._epochs):
            losses = []
            lots = list(self._order(epoch))
            for place, indices in enumerate(lots):
                # Each lot of contacts has its own seed, so a resumed training draws the same
                # numbers.
                rng = np.random.default_rng([self._seed, epoch, place])
                for part, lot in enumerate(self._lots(indices, rng)):
                    gone = (epoch + (place + part * BATCH / PREPARED) / len(lots)) / self._epochs
                    losses.append(self._step(lot, gone))
            self._done = epoch + 1
            self._save_state()
            progress(self._done, float(np.mean(losses)))
        return self._full

    def _order(self, epoch: int) -> Iterator[NDArray[np.intp]]:
        order = np.random.default_rng([self._seed, epoch]).permutation(len(self._examples))
        for start in range(0, len(order), PREPARED):
            yield order[start : start + PREPARED]

    def _lots(self, indices: NDArray[np.intp], rng: np.random.Generator) -> Iterator[Lot]:
        drawn = draw_batch(self._examples, indices, rng)
        x = torch.from_numpy(self._full.scaled("inputs", drawn.x))
        general = torch.from_numpy(self._full.scaled("general", drawn.general))
        row, is_known = torch.from_numpy(drawn.row), torch.from_numpy(drawn.is_known).float()
        target = torch.from_numpy(((drawn.shore_a - CENTRE) / UNIT).astype(np.float32))
        for start in range(0, len(x), BATCH):
            part = slice(start, start + BATCH)
            present = self._there[row[part]] * is_known[part, None]
            yield x[part], self._tokens[row[part]], present, general[part], target[part]

    def _step(self, lot: Lot, gone: float) -> float:
        x, tokens, present, general, target = lot
        for group in self._optimizer.param_groups:
            group["lr"] = RATE * rate_share(gone)
        outputs = self._network(x, tokens, present, general)
        loss = expected_loss(outputs, target[:, None], torch.ones_like(target)[:, None])
        self._optimizer.zero_grad()
        torch.autograd.backward(loss)
        torch.nn.utils.clip_grad_norm_(self._network.parameters(), 1.0)
        self._optimizer.step()
        return float(loss.item())

    def _save_state(self) -> None:
        state = {
            "epoch": self._done,
            "network": self._network.state_dict(),
            "optimizer": self._optimizer.state_dict(),
        }
        with replacing(self._state) as temporary:
            torch.save(state, temporary)

    def _load_state(self) -> None:
        state = torch.load(self._state, weights_only=True)
        self._done = state["epoch"]
        self._network.load_state_dict(state["network"])
        self._optimizer.load_state_dict(state["optimizer"])


def expected_loss(
    outputs: tuple[torch.Tensor, torch.Tensor, torch.Tensor],
    targets: torch.Tensor,
    weights: torch.Tensor,
) -> torch.Tensor:
    """Return the weighted mean loss of predicted mixtures: squared error minus log-likelihood."""
    weight, mean, spread = (part[:, None] for part in outputs)
    away = (targets[..., None] - mean) / spread.exp()
    likelihood = torch.logsumexp(weight - spread - 0.5 * away * away, 2)
    error = (weight.exp() * mean).sum(2) - targets
    return (weights * (SQUARED * error * error - likelihood)).sum(1).mean()


def rate_share(gone: float) -> float:
    """Return the learning rate as a share of ``RATE``.

    ``gone`` is the share of the training that is finished, from 0 to 1.
    """
    if gone < WARM_UP:
        return 0.04 + 0.96 * gone / WARM_UP
    return 0.5 * (1 + math.cos(math.pi * min((gone - WARM_UP) / (1 - WARM_UP), 1.0)))


def input_scales(examples: Examples, seed: int) -> dict[str, NDArray[np.float32]]:
    """Return (mean, standard deviation) arrays for the inputs of the network, by name.

    They are computed over some of the contacts. The keys are NAME.mean and NAME.sd.
    """
    rng = np.random.default_rng([seed, 0, 0, 1])
    indices = np.unique(np.linspace(0, len(examples) - 1, 20_000).round().astype(np.intp))
    batch = draw_batch(examples, indices, rng)
    tokens, present = token_rows(examples)
    parts = {"inputs": batch.x, "token": tokens[present > 0], "general": examples.general}
    out: dict[str, NDArray[np.float32]] = {}
    for name, part in parts.items():
        rows = part.reshape(-1, part.shape[-1])
        out[f"{name}.mean"] = rows.mean(axis=0, dtype=np.float64).astype(np.float32)
        out[f"{name}.sd"] = (rows.std(axis=0, dtype=np.float64) + 1e-2).astype(np.float32)
    return out
