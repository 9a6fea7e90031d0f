"""The experiment ``reflex_arm`` with the arm in OpenSim."""
