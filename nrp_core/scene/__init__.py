"""Robots and rooms as data, and their readers.

:mod:`~nrp_core.scene.model` is the data; :func:`~nrp_core.scene.sdf.read_model` and
:func:`~nrp_core.scene.sdf.read_scene` read SDF and URDF. The other modules here serve both formats.
"""
