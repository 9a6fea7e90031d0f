"""Devices that drive and record neurons, the same on every backend."""
