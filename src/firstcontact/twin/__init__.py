"""The pinch twin: a physical model that makes recordings."""
