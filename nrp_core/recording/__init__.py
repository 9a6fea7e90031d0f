"""Recordings: a folder with the experiment's files, what ran, and every message in one MCAP file."""
