"""The shared parts of engines with joints: bodies, servos, drives, options.

An engine derives from ``JointedEngine``, its entry point from ``PhysicsBackend``, and its options from
``PhysicsOptions``; all three are in ``jointed.py``.
"""
