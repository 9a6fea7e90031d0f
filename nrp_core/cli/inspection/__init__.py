"""The parts of ``nrp inspect``: one module for each thing that it describes."""
