"""The computations of the host before a run: numbers and tables for the machine."""
