"""A model for the twin, for whoever has none yet: made once, kept in the user's cache."""

from __future__ import annotations

import io
import os
import sys
from contextlib import redirect_stdout
from importlib.metadata import version
from pathlib import Path

#: What recordings of the twin say of where they come from.
ORIGIN = "twin"
#: Pinches of each block that it learns from: enough for a first look in half a minute.
PINCHES = 60
#: Raised whenever what is trained here changes, so that older ones are not used.
RECIPE = 2


def cache_folder() -> Path:
    """Where it is kept: ``XDG_CACHE_HOME``, or ``~/.cache``."""
    base = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(base) / "firstcontact"


def twin_model(condition: str, seed: int) -> Path:
    """Folder of a model and a detector trained on the twin; simulated and trained when missing.

    Parameters
    ----------
    condition
        Of the twin.
    seed
        Of the twin's hand; the pinches learned from are other ones than those shown live.
    """
    folder = cache_folder() / f"twin-{version('firstcontact')}.{RECIPE}-{condition}-{seed}"
    if (folder / "detector.json").is_file():
        return folder
    from firstcontact.cli.verbs.simulate import Simulate
    from firstcontact.cli.verbs.train import Train
    from firstcontact.core import need, temporary_beside

    need("twin", "numba")
    print(f"no --model: one is trained on the twin first and kept in {folder}", file=sys.stderr)
    with temporary_beside(folder) as making:
        making.mkdir()
        learned = io.StringIO()
        with redirect_stdout(learned):  # it names folders that are gone when it is read
            Simulate(
                making / "pinches",
                condition,  # type: ignore[arg-type]  # the twin refuses other names
                PINCHES,
                pinches_per_object=0,
                seed=seed,
            ).run()
            Train(making / "pinches", making / "model", contacts="detected").run()
        for line in learned.getvalue().splitlines():
            if str(making) not in line:
                print(line, file=sys.stderr)
        try:
            (making / "model").rename(folder)
        except OSError:
            # Another run may have made it meanwhile: then it is there, whole.
            if not (folder / "detector.json").is_file():
                raise
    return folder
