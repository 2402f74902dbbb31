"""Option ``--cluster``: machines that do the heavy computing of a verb."""

from __future__ import annotations

from contextlib import AbstractContextManager, nullcontext

from firstcontact.core import require_modules


def on_cluster(cluster: str | None) -> AbstractContextManager[None]:
    """Return a context manager in whose block heavy computing runs on a cluster.

    ``cluster`` is the address of the scheduler. If it is None, this machine computes.

    Raises
    ------
    InputError
        The extra packages are not installed. On entering the block: the cluster cannot be used.
    """
    if cluster is None:
        return nullcontext()
    require_modules("cluster", "distributed")
    from firstcontact.core import use_cluster

    return use_cluster(cluster)
