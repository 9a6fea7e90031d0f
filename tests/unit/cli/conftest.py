"""The command line, in this process or in one of its own, with engines that simulate nothing."""

from command_fixtures import experiment, nrp, nrp_process

__all__ = ["experiment", "nrp", "nrp_process"]
