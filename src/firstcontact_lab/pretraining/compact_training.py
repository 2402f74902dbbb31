"""Training of the compact network, which imitates the uncompressed (teacher) networks."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np
import torch
from numpy.typing import NDArray
from torch import nn

from firstcontact.models.rig.context_network import ContextNetwork
from firstcontact.models.rig.rigs import Rig
from firstcontact_lab.pretraining.batches import Batch, draw_batch, token_rows
from firstcontact_lab.pretraining.examples import Examples
from firstcontact_lab.pretraining.training import (
    BATCH,
    BODY,
    CENTRE,
    CONTEXT,
    HEADS,
    MEAN_SCALE,
    PREPARED,
    SPREAD,
    TOKENS,
    UNIT,
    Full,
    TorchNetwork,
    expected_loss,
    rate_share,
)

_FARTHEST = ContextNetwork.FARTHEST

#: Number of directions of each thin layer: the rank of the two matrices.
DIRECTIONS: Mapping[str, int] = {"query1": 32, "body1": 36, "body2": 32, "body3": 24}
#: Number of training steps, largest learning rate, and passes over a set of prepared contacts.
STEPS, RATE, PASSES = 16_000, 3e-3, 2
#: Largest sum of the magnitudes of a row's integers. Its product with 32,767 stays below 2^31.
MOST = 65_000
#: Share of the mean that is added to the Fisher information of a layer's outputs, so that it can be
#: inverted.
_FLOOR = 1e-2

Lot = tuple[torch.Tensor, ...]
Outputs = tuple[torch.Tensor, torch.Tensor, torch.Tensor]


def train_compact(
    teachers: Sequence[Full],
    examples: Examples,
    seed: int,
    steps: int = STEPS,
    directions: Mapping[str, int] = DIRECTIONS,
    progress: Callable[[int, float], object] = lambda step, loss: None,
) -> ContextNetwork:
    """Train and return a compact network that predicts the mean of the teachers' distributions."""
    sources = [_Lots(teacher, examples) for teacher in teachers]

    def drawn(number: int) -> Batch:
        rng = np.random.default_rng([seed, number])
        return draw_batch(examples, rng.permutation(len(examples))[:PREPARED], rng)

    compact = _TorchCompact(directions)
    first = sources[0].lot(drawn(0))
    compact.begin_as(teachers[0].network, first)
    optimizer = torch.optim.AdamW(compact.parameters(), RATE, weight_decay=0.0)
    step, number = 0, 0
    while step < steps:
        number += 1
        rng = np.random.default_rng([seed, number])
        # All teachers see the same contacts with the same placement and hints.
        batch = drawn(number)
        lots = [source.lot(batch) for source in sources]
        lot, losses = lots[0], []
        targets = [
            _targets(teacher.network, seen) for teacher, seen in zip(teachers, lots, strict=True)
        ]
        points, weights = (torch.cat(parts, 1) for parts in zip(*targets, strict=True))
        order = np.concatenate([rng.permutation(len(points)) for _ in range(PASSES)])
        for start in range(0, max(len(order) - BATCH, 0) + 1, BATCH):
            if step == steps:
                break
            rows = torch.from_numpy(order[start : start + BATCH])
            for group in optimizer.param_groups:
                group["lr"] = RATE * rate_share(step / steps)
            outputs = compact(*(part[rows] for part in lot[:-1]))
            loss = expected_loss(outputs, points[rows], weights[rows] / len(teachers))
            optimizer.zero_grad()
            torch.autograd.backward(loss)
            nn.utils.clip_grad_norm_(compact.parameters(), 1.0)
            optimizer.step()
            losses.append(float(loss.item()))
            step += 1
        progress(step, float(np.mean(losses)))
    return ContextNetwork(compact.arrays(teachers[0]))


def _linear(network: TorchNetwork) -> dict[str, nn.Linear]:
    return {name: x for name, x in network.layers.items() if isinstance(x, nn.Linear)}


class _Lots:
    """Maker of a network's training inputs from batches. Each rig is encoded only once."""

    def __init__(self, full: Full, examples: Examples) -> None:
        self._full = full
        tokens, present = token_rows(examples)
        self._present = torch.from_numpy(present)
        with torch.no_grad():
            self._codes = torch.cat(
                [
                    full.network.encoded(self._scaled("token", part))
                    for part in np.array_split(tokens, 64)
                ]
            )

    def lot(self, batch: Batch) -> Lot:
        """Return the inputs of the network for a batch, and the scaled Shore A of each contact.

        The result is (inputs, codes of the rig's blocks, mask of the codes, general features, Shore
        A).
        """
        row = torch.from_numpy(batch.row)
        present = self._present[row] * torch.from_numpy(batch.is_known).float()[:, None]
        target = torch.from_numpy(((batch.shore_a - CENTRE) / UNIT).astype(np.float32))
        x, general = self._scaled("inputs", batch.x), self._scaled("general", batch.general)
        return x, self._codes[row], present, general, target

    def _scaled(self, name: str, x: NDArray[np.float32]) -> torch.Tensor:
        return torch.from_numpy(np.clip(self._full.scaled(name, x), -_FARTHEST, _FARTHEST))


def _targets(full: TorchNetwork, lot: Lot) -> tuple[torch.Tensor, torch.Tensor]:
    """Return (points, weights) that represent the distributions predicted by the full network.

    Each normal distribution of a mixture has three points.
    """
    with torch.no_grad():
        parts = [
            full.predict(*part)
            for part in zip(*(torch.split(x, 2048) for x in lot[:-1]), strict=True)
        ]
    weight, mean, spread = (torch.cat(part) for part in zip(*parts, strict=True))
    away, share = 3**0.5 * spread.exp(), weight.exp()
    points = torch.cat([mean - away, mean, mean + away], 1)
    return points, torch.cat([share / 6, share * 2 / 3, share / 6], 1)


class _TorchCompact(nn.Module):
    """Compact network in PyTorch, with floating-point weights."""

    def __init__(self, directions: Mapping[str, int]) -> None:
        super().__init__()
        sizes = {n: (x.in_features, x.out_features) for n, x in _linear(TorchNetwork()).items()}
        sizes["body1"] = BODY, BODY  # the rig's part of the inputs is in ``rig``
        self.into = {
            n: nn.Linear(sizes[n][0], directions[n], bias=False) for n in ContextNetwork.THIN
        }
        self.out = {n: nn.Linear(directions[n], sizes[n][1]) for n in ContextNetwork.THIN}
        self.thin = nn.ModuleList([*self.into.values(), *self.out.values()])
        self.pool = nn.Linear(TOKENS, HEADS, bias=False)
        described = (1 + HEADS) * TOKENS + Rig.GENERAL + 1
        self.rig = nn.Linear(described, directions["body1"], bias=False)
        self.answer = nn.Linear(*sizes["answer"])

    def forward(
        self, x: torch.Tensor, e: torch.Tensor, present: torch.Tensor, general: torch.Tensor
    ) -> Outputs:
        silu, count = nn.functional.silu, present.sum(1, keepdim=True)
        fit = self.pool(e) - 1e4 * (1 - present[..., None])
        share = torch.softmax(fit, 1) * present[..., None]
        mean = present[..., None] / count.clamp(min=1)[..., None]
        pooled = torch.cat([mean, share], 2).transpose(1, 2) @ e
        described = torch.cat([pooled.flatten(1), general, (count > 0).float()], 1)
        h = x
        for name in ContextNetwork.THIN:
            z = self.into[name](h)
            h = silu(self.out[name](z + self.rig(described) if name == "body1" else z))
        weight, centre, spread = self.answer(h).chunk(3, dim=1)
        return torch.log_softmax(weight, 1), MEAN_SCALE * centre, spread.clamp(*SPREAD)

    def begin_as(self, full: TorchNetwork, lot: Lot) -> None:
        """Set the weights to a low-rank approximation of the full network.

        The approximation is best for the contacts in ``lot``.
        """
        heard = _layer_gradients(full, lot)
        layers = _linear(full)
        query = heard["query2"][0].mean(0).reshape(HEADS, -1, 1)
        keys = layers["key"].weight.detach().reshape(HEADS, -1, TOKENS)
        values = layers["value"].weight.detach().reshape(HEADS, -1, TOKENS)
        with torch.no_grad():
            for name in ContextNetwork.THIN:
                into, out, bias = _low_rank(layers[name], *heard[name], len(self.into[name].weight))
                self.into[name].weight.copy_(into[:, : self.into[name].in_features])
                self.out[name].weight.copy_(out)
                self.out[name].bias.copy_(bias)
                if name == "body1":
                    ends = BODY, BODY + CONTEXT, BODY + 2 * CONTEXT
                    mean, attended, general = into.tensor_split(ends, 1)[1:]
                    each = attended.reshape(len(into), HEADS, 1, -1)
                    means = mean @ layers["mean"].weight, (each @ values).flatten(1)
                    constant = mean @ layers["mean"].bias + attended @ layers["value"].bias
                    self.rig.weight.copy_(torch.cat([*means, general, constant[:, None]], 1))
            self.pool.weight.copy_((query * keys).sum(1) / query.shape[1] ** 0.5)
            self.answer.load_state_dict(layers["answer"].state_dict())

    def arrays(self, full: Full) -> dict[str, NDArray[np.generic]]:
        """Return the trained arrays by name.

        The arrays that encode a rig's blocks are those of the full network.
        """
        out: dict[str, NDArray[np.generic]] = dict(full.scales)
        layers = {"pool": self.pool, "term": self.rig, "answer": self.answer}
        for name in ("token1", "token2"):
            layers[name] = _linear(full.network)[name]
            out[f"{name}.bias"] = layers[name].bias.detach().numpy().copy()
        for name, layer in layers.items():
            out[f"{name}.weight"] = layer.weight.detach().numpy().copy()
        out["answer.bias"] = self.answer.bias.detach().numpy().copy()
        for name in ContextNetwork.THIN:
            for part, layer in (("into", self.into[name]), ("out", self.out[name])):
                out |= quantize_rows(f"{name}.{part}", layer.weight.detach().numpy())
            out[f"{name}.out.bias"] = self.out[name].bias.detach().numpy().copy()
        return out


def _layer_gradients(full: TorchNetwork, lot: Lot) -> dict[str, tuple[torch.Tensor, torch.Tensor]]:
    """Return (outputs, gradients) of each layer of the full network, by the layer's name.

    The gradients are those of the loss with respect to the outputs.
    """
    heard: dict[str, torch.Tensor] = {}

    def listen(name: str) -> Callable[[nn.Module, object, torch.Tensor], None]:
        def hear(layer: nn.Module, inputs: object, outputs: torch.Tensor) -> None:
            outputs.retain_grad()
            heard[name] = outputs

        return hear

    layers = _linear(full)
    hooks = [layers[n].register_forward_hook(listen(n)) for n in (*ContextNetwork.THIN, "query2")]
    outputs = full.predict(*lot[:-1])
    for hook in hooks:
        hook.remove()
    target = lot[-1][:, None]
    torch.autograd.backward(expected_loss(outputs, target, torch.ones_like(target)))
    gradients = {name: y.grad for name, y in heard.items()}
    return {
        name: (y.detach(), g) for name, y in heard.items() if (g := gradients[name]) is not None
    }


def _low_rank(
    layer: nn.Linear, outputs: torch.Tensor, gradients: torch.Tensor, directions: int
) -> tuple[torch.Tensor, torch.Tensor, torch.Tensor]:
    """Return (first matrix, second matrix, bias), a low-rank approximation of a layer.

    The first matrix maps the inputs to ``directions`` main directions of the outputs. The second
    maps these to the outputs.
    """
    weight, bias = (p.detach().double() for p in (layer.weight, layer.bias))
    y, g = outputs.double(), gradients.double()
    effect = g.T @ g
    effect = effect / effect.diagonal().mean() + _FLOOR * torch.eye(len(effect))
    size, axes = torch.linalg.eigh(effect)
    root, inverse = ((axes * size**power) @ axes.T for power in (0.5, -0.5))
    mean = y.mean(0)
    away = (y - mean) @ root
    main = torch.linalg.eigh(away.T @ away)[1].flip(1)[:, :directions]
    into, out = main.T @ root @ weight, inverse @ main
    bias = mean + out @ (main.T @ root @ (bias - mean))
    balance = (into.norm(dim=1) / out.norm(dim=0)).sqrt()  # equal sizes suit the optimizer
    return (into / balance[:, None]).float(), (out * balance).float(), bias.float()


def quantize_rows(name: str, weight: NDArray[np.floating]) -> dict[str, NDArray[np.generic]]:
    """Return a matrix as 16-bit integers with one scale per row.

    The keys are ``NAME.weight`` and ``NAME.scale``.
    """
    least = np.maximum(np.abs(weight).sum(axis=1) / MOST, np.abs(weight).max(axis=1) / 32_000)
    scale = np.maximum(least, 1e-30).astype(np.float32)
    return {
        f"{name}.weight": np.rint(weight / scale[:, None]).astype(np.int16),
        f"{name}.scale": scale,
    }
