"""Recordings as they are written: signals, messages, hashes."""
