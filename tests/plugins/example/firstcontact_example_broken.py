"""A plug-in whose library is not there."""

raise ImportError("libtoy is missing: install it")
