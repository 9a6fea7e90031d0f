"""Sensors: each reads the engine and makes messages of it."""
