"""Recordings: writer, tolerant reader, importers, exporters."""
