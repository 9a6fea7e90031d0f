"""Parameters of brain scripts and transfer functions: declared there, set by experiments."""

from nrp_core.parameters.parameter import GivenParameters, Parameter, Value, fitting
from nrp_core.parameters.reading import BRAIN, FUNCTIONS, Declared, read_in_groups, read_parameters

__all__ = [
    "BRAIN",
    "FUNCTIONS",
    "Declared",
    "GivenParameters",
    "Parameter",
    "Value",
    "fitting",
    "read_in_groups",
    "read_parameters",
]
