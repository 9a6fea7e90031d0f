"""Devices that drive neurons and listen to them, the same on every backend."""
