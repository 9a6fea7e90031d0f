"""The grid with work only where events go: the same grid points, the same spikes.

A neuron stays as it was after its last event until the next one reaches it, or its voltage may reach the
threshold.
"""
