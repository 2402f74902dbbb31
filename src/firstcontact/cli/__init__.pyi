"""The ``firstcontact`` command: one verb a file in ``verbs``, and what verbs share."""

from .choices import one_of as one_of
from .cluster import where as where
