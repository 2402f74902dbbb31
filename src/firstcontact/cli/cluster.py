"""``--cluster``: where the heavy work of a verb is done."""

from __future__ import annotations

from contextlib import AbstractContextManager, nullcontext

from firstcontact.core import need


def where(cluster: str | None) -> AbstractContextManager[None]:
    """A block whose heavy work is done on the cluster at an address, or here where there is none.

    Raises
    ------
    InputError
        The extra is missing; or, on entering, the cluster cannot be used.
    """
    if cluster is None:
        return nullcontext()
    need("cluster", "distributed")
    from firstcontact.core import on_cluster

    return on_cluster(cluster)
