"""The grid mode: spikes lie on the points of a grid of times, all neurons advance in step.

For dense networks, where every neuron has something to do in every step anyway.
"""
