"""Plug-in that imports a missing library."""

raise ImportError("libtoy is missing: install it")
