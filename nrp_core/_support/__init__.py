"""Utilities for the platform itself: compiling, caches, files, child processes."""
