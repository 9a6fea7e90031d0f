"""The commands ``nrp sweep``, ``evolve``, ``diff`` and ``benchmark``."""
