"""Neurons, chosen by name, index and location."""
