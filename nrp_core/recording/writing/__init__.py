"""Writing recordings: signals, messages, hashes."""
