"""What a hand can do with what it feels: one policy a file, all in the registry."""
