"""Rays against the collision shapes of a scene, the same in every engine."""
