"""Scripts of sPyNNaker on the brain backends of nrp-core: its dialect of PyNN, and its live connections."""
