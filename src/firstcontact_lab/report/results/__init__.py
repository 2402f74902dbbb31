"""What studies find, as records: each part its own; :mod:`.file` reads and writes them."""
