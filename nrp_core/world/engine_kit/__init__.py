"""The shared parts of engines with joints: bodies, servos, drives, options.

An engine derives from ``JointedEngine`` in ``jointed.py``, its entry point from ``PhysicsBackend`` in
``backend.py``, and its options from ``PhysicsOptions`` in ``options.py``.
"""
