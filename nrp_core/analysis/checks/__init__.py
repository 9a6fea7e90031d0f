"""The checks, one module for each family; importing this registers them in the order of their codes."""

from nrp_core.analysis.checks import (
    attributes,
    beginnings,
    calls,
    capabilities,
    conditions,
    items,
    messages,
    names,
    never,
    numbers,
    parameters,
    populations,
    times,
    values,
    variables,
    writers,
)

__all__ = [
    "attributes",
    "beginnings",
    "calls",
    "capabilities",
    "conditions",
    "items",
    "messages",
    "names",
    "never",
    "numbers",
    "parameters",
    "populations",
    "times",
    "values",
    "variables",
    "writers",
]
