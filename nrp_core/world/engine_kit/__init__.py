"""The shared parts of engines with joints: bodies, servos, drives, options."""
