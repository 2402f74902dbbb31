"""Warnings about unusable parts of recordings."""

from __future__ import annotations

from firstcontact.core import Dataset


def print_losses(dataset: Dataset) -> None:
    """Print a warning for each part of a recording that could not be loaded."""
    for sentence in dataset.losses:
        print(f"warning: {sentence}")
