"""The options of the backend, which its engine has, too."""

from __future__ import annotations

from typing import Annotated, Literal

from nrp_core.clock import NS_PER_MS
from nrp_core.quantities import DurationNs
from nrp_core.world import WorldOptions
from pydantic import Field


class OpensimOptions(WorldOptions):
    """Options of the ``opensim`` backend."""

    timestep: Annotated[
        DurationNs,
        Field(gt=0, description="the time after which the integrator begins anew; excitations hold for it"),
    ] = 2 * NS_PER_MS
    integrator: Annotated[
        Literal[
            "RungeKuttaMerson",
            "RungeKuttaFeldberg",
            "RungeKutta3",
            "RungeKutta2",
            "SemiExplicitEuler2",
            "Verlet",
            "CPodes",
        ],
        Field(description="the integrator, by OpenSim's name; its steps adapt to the accuracy"),
    ] = "RungeKuttaMerson"
    accuracy: Annotated[float, Field(gt=0, lt=1, description="the accuracy of the integrator")] = 1e-4
    renderer: Annotated[
        Literal["auto", "raster", "realistic"],
        Field(
            description="of cameras: raster (auto) draws flat colours on the CPU, realistic light and shadows"
        ),
    ] = "auto"
