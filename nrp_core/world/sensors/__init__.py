"""Sensors, in modules by measured quantity: their data, their elements in files, and their messages.

To add one, add its module and name it under ``nrp_core.sensors`` in ``pyproject.toml``.
"""
