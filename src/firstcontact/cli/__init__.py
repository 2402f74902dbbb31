"""The ``firstcontact`` command: one verb a file in ``verbs``, and what verbs share."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
