"""Controllers of joints, alone or along trajectories.

To add one, name its reader under ``nrp_core.controllers`` in ``pyproject.toml``, by the name of the
``<plugin>`` that it reads.
"""
