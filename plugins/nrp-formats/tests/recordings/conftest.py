"""The recording of a drive, of a brain that fires when told and a world of discs that drive."""

from experiment_fixtures import site
from recording_fixtures import brain, make_rig, recorded_drive, rig, world

__all__ = ["brain", "make_rig", "recorded_drive", "rig", "site", "world"]
