"""The page: a sink that shows what happens to whoever opens it in a browser."""

from firstcontact.streaming.page._sink import PageSink

__all__ = ["PageSink"]
