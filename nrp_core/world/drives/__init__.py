"""Drives: they move a robot as a whole.

To add one, add its module and name it under ``nrp_core.drives`` in ``pyproject.toml``, by the name of the
``<plugin>`` that it reads.
"""
