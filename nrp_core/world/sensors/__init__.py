"""Sensors: each reads the engine and creates messages."""
