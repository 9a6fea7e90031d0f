"""Options of the ``brian2`` backend."""

from __future__ import annotations

from typing import Final, Literal

from nrp_core.brain import RemoteOptions
from pydantic import Field

NAME: Final = "Brian2"
INSTALL: Final = "pip install 'brian2>=2.9'"
CELL: Final = "Brian2Group"
"""The cell type of a group of Brian2 in a network, which knows nothing of its equations."""
RECEPTORS: Final = {"excitatory": ("ge", "v"), "inhibitory": ("gi", "v")}
"""The variables that receive spikes of devices, if the options name none: the first that a group has."""


class Brian2Options(RemoteOptions):
    """Options of the ``brian2`` backend."""

    compiled: bool = Field(
        default=False, description="whether Brian2 compiles with Cython, unless the script chooses its target"
    )
    inputs: dict[Literal["current", "excitatory", "inhibitory"], str] = Field(
        default_factory=dict,
        description="the variable of the groups that a device's current sets, and those to which spikes on a "
        "receptor add their weight; by default the parameter in ampere, `ge` and `gi`, or else `v`",
    )
