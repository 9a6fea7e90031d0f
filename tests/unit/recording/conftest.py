"""A recorder on a brain that fires when told and a world of discs that drive."""

from recording_fixtures import brain, make_rig, recorded_drive, rig, world

__all__ = ["brain", "make_rig", "recorded_drive", "rig", "world"]
