"""Poses, rotations and motions of rigid bodies: values that every other room of a world uses."""
