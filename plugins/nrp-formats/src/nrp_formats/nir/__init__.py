"""Networks of the Neuromorphic Intermediate Representation (Pedersen et al. 2024, Nat. Commun. 15:8122).

A file is a graph of nodes. Neurons become populations, and the linear nodes between two of them become one
matrix of synapses.
"""
