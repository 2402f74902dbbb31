"""The ``firstcontact`` command: one verb a file in ``verbs``, and what verbs share."""

from .options import Option as Option
from .options import choice as choice
from .options import on_cluster as on_cluster
