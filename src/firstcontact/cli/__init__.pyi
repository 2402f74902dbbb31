"""The ``firstcontact`` command: one verb a file in ``verbs``, and what verbs share."""

from .cluster import on_cluster as on_cluster
from .options import Option as Option
from .options import choice as choice
