"""Recordings: a folder with the experiment's files, data about the run, and every message in an MCAP file."""
