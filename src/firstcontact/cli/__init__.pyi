"""The ``firstcontact`` command: one verb a file in ``verbs``, and what verbs share."""

from .cluster import where as where
from .options import Option as Option
from .options import one_of as one_of
