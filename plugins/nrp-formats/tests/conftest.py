"""The command line in this process."""

from command_fixtures import nrp

__all__ = ["nrp"]
