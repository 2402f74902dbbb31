"""What of the recordings could not be used, for the commands that learn from them."""

from __future__ import annotations

from firstcontact.core import Dataset


def warn_of(dataset: Dataset) -> None:
    """Print a warning for everything that was left out or lost when the dataset was loaded."""
    for sentence in dataset.losses:
        print(f"warning: {sentence}")
