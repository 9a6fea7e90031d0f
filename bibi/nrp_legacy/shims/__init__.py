"""Modules that experiments import: the part of each that they use, on topics and simulated time of ours."""
