"""Modules that experiments import: the parts that they use, based on our topics and simulated time."""
