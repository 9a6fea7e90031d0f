"""Experiments of NRP-core 4, the program of EBRAINS, on brains and worlds of this program.

``reader`` reads a ``simulation_config.json``, ``maker`` makes its parts, and ``loop`` runs its functions and
engines in the order of that program. Files of such an experiment import ``nrp_core`` and ``nrp_protobuf``;
within these files alone, the names stand for the modules that :mod:`nrp_ebrains.modules` makes.
"""
