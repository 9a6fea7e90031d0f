"""The start page: the experiments, recordings and sweeps that can be opened."""
