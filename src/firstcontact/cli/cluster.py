"""Option ``--cluster``: the machines for the heavy work of a verb."""

from __future__ import annotations

from contextlib import AbstractContextManager, nullcontext

from firstcontact.core import require_modules


def on_cluster(cluster: str | None) -> AbstractContextManager[None]:
    """Return a context in which heavy work runs on a cluster; without an address it runs here.

    Raises
    ------
    InputError
        The extra is missing, or (on entering) the cluster cannot be used.
    """
    if cluster is None:
        return nullcontext()
    require_modules("cluster", "distributed")
    from firstcontact.core import use_cluster

    return use_cluster(cluster)
