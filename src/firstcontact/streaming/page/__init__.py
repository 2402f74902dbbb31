"""Live page: a sink that shows the session in a browser."""

from firstcontact.streaming.page._sink import PageSink

__all__ = ["PageSink"]
