"""Runs repeated from their recordings, and compared with them."""
