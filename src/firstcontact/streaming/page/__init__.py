"""Live page: a sink that shows the session in a browser."""
