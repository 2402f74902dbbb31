"""Figures of the study with object names and units of any text, without warnings."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from firstcontact.core import Dataset
from firstcontact_lab.study.part import Subject
from firstcontact_lab.study.parts.hardness import hardness_figure

NAMES = [
    r"$\frac{$", "$x^2$", r"\alpha", "a\nb", "\x1b[31mred", "\x00", "x" * 200, "苹果苹果苹果苹果",
    "🍎" * 50, "<b>",
]  # fmt: skip


@pytest.mark.parametrize("name", NAMES, ids=ascii)
def test_objects_may_have_any_name(make_shore: Callable[..., Dataset], name: str) -> None:
    dataset = make_shore(each=4)
    pinches = tuple(
        replace(p, label=replace(p.label, object=name, specimen=name, hardness_rank=i % 3))
        for i, p in enumerate(dataset.pinches)
    )
    subject = Subject("a", replace(dataset, pinches=pinches))
    data = subject.windows(0.015)
    ranked = subject.labelled_windows(0.015, subject.dataset.hardness_rank)
    figure = hardness_figure(ranked, np.ones(len(data)))
    assert figure.image.startswith("data:image/svg+xml")
