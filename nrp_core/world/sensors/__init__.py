"""Sensors, one module each: its data, its element in files, and the messages it publishes.

To add one, add its module and name it under ``nrp_core.sensors`` in ``pyproject.toml``. An element of its own
in ``<sensor>`` is also named in ``nrp_core/world/scene/sdf/vocabulary.py``.
"""
