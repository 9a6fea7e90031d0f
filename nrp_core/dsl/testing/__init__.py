"""Mocks and a rig to test transfer functions without simulators."""
