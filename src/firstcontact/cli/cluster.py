"""Option ``--cluster``: machines that do the heavy computing of a verb."""

from __future__ import annotations

from contextlib import AbstractContextManager, nullcontext

from firstcontact.core import require_modules


def on_cluster(cluster: str | None) -> AbstractContextManager[None]:
    """Return a context in which heavy computing runs on a cluster; without an address, locally.

    Raises
    ------
    InputError
        The extra packages are not installed or, on entering the context, the cluster cannot be
        used.
    """
    if cluster is None:
        return nullcontext()
    require_modules("cluster", "distributed")
    from firstcontact.core import use_cluster

    return use_cluster(cluster)
