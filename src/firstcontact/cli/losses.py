"""Warnings about data in recordings that cannot be used."""

from __future__ import annotations

from firstcontact.core import Dataset


def print_losses(dataset: Dataset) -> None:
    """Print a warning for each piece of a recording that could not be loaded."""
    for sentence in dataset.losses:
        print(f"warning: {sentence}")
