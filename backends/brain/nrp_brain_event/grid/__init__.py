"""The grid mode: spikes are on the points of a time grid, and all neurons advance in steps.

It is for dense networks, in which every neuron has work in every step.
"""
