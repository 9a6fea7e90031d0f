"""Poses, rotations and motions of rigid bodies, used by all other packages of a world."""
