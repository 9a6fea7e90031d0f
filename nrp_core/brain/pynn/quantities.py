"""Values with units in the arguments of cells and synapses that are given as equations."""

# mypy: disable-error-code="misc"

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from nrp_core.brain.network.equations.expressions import TextOrigin
from nrp_core.brain.network.equations.units import Unit, quantity
from nrp_core.errors import NetworkError, did_you_mean


def value_with_unit(where: str, name: str, value: Any, kind: str) -> tuple[float, Unit]:
    """Return a number and its unit, from a text or a plain number.

    Args:
        where: the argument that has it.
        name: what has the value.
        value: the value.
        kind: what is given as equations, by its name in scripts.

    Raises:
        NetworkError: it is not a quantity.
    """
    place = TextOrigin(where, f"{name}: {value}", kind=kind)
    if isinstance(value, (bool, np.bool_)) or not isinstance(value, (str, int, float, np.number)):
        place.refuse(
            "its default is a number with a unit, e.g. '20 ms'; values of each one go to the type itself"
        )
    try:
        return quantity(str(value))
    except ValueError as error:
        place.refuse(str(error))


def require_texts(
    kind: str, texts: Mapping[str, Any], examples: Mapping[str, str], unknown: Mapping[str, Any]
) -> None:
    """Refuse arguments that are not texts, and those that there are not.

    Args:
        kind: what is given as equations, by its name in scripts.
        texts: the arguments that are texts.
        examples: an example of each.
        unknown: other arguments.

    Raises:
        NetworkError: an argument is wrong.
    """
    for argument in unknown:
        hint = did_you_mean(argument, [*examples, "parameters", "initial", "receptors", "method"])
        raise NetworkError(
            f"{kind} has no argument '{argument}'{hint}; parameters are given as "
            f"parameters={{'{argument}': '20 ms'}}"
        )
    for what, text in texts.items():
        if not isinstance(text, str):
            raise NetworkError(f"{kind}: {what} is a text, e.g. {examples[what]!r}, not {text!r}")


def require_dictionaries(kind: str, arguments: Mapping[str, object]) -> None:
    """Refuse arguments that are not dictionaries.

    Args:
        kind: what is given as equations, by its name in scripts.
        arguments: the arguments by name.

    Raises:
        NetworkError: an argument is something else.
    """
    for name, given in arguments.items():
        if not isinstance(given, Mapping):
            example = {"receptors": "{'excitatory': 'ge'}", "initial": "{'v': '-65 mV'}"}
            valid = example.get(name, "{'tau': '20 ms'}")
            raise NetworkError(f"{kind}: {name} is a dictionary, e.g. {valid}, not {given!r}")
