"""The values of parameters while a script runs, one object for each run of a script."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import TypeVar

from nrp_core.errors import ExperimentError, ParameterError, did_you_mean
from nrp_core.parameters.parameter import Parameter, Value

V = TypeVar("V", bound="bool | int | float | str | list[float] | list[int]")


class GivenParameters:
    """Answers the calls of ``parameter`` in one script.

    Args:
        values: the values that the experiment gives; others have their defaults.
    """

    def __init__(self, values: Mapping[str, object] = MappingProxyType({})) -> None:
        self._values = dict(values)
        self._declared: dict[str, Parameter] = {}

    @property
    def unused(self) -> list[str]:
        """The given values that the script has not asked for so far."""
        return [name for name in self._values if name not in self._declared]

    @property
    def declared(self) -> list[str]:
        """The parameters that the script has declared so far."""
        return list(self._declared)

    def parameter(
        self,
        name: str,
        default: V,
        *,
        unit: str | None = None,
        low: float | None = None,
        high: float | None = None,
        doc: str = "",
    ) -> V:
        """Declare a parameter of this file and return its value: that of the experiment, or the default.

        All arguments are literals, since checks read them without executing the file.

        Args:
            name: an identifier; ``-s brain.parameters.NAME=VALUE`` sets it.
            default: a bool, int, float, str or a list of numbers; values are of its type.
            unit: of its numbers, such as ``mV``; values in other units are converted.
            low: the smallest valid number.
            high: the largest valid number.
            doc: one sentence on what it does.

        Raises:
            ExperimentError: the declaration contradicts itself or another of the same name, or the value
                does not fit.
        """
        declared = Parameter(name, default, unit, low, high, doc)  # type: ignore[arg-type]
        if self._declared.setdefault(name, declared) != declared:
            raise ParameterError(f"parameter '{name}' is declared twice, with different arguments")
        try:
            found: Value = declared.value(self._values.get(name, default))
        except ValueError as error:
            raise ExperimentError(str(error)) from None
        return found  # type: ignore[return-value]


def fitting(
    declared: Mapping[str, Parameter], given: Mapping[str, object]
) -> tuple[dict[str, Value], dict[str, str]]:
    """Compare values with declarations.

    Returns:
        the value of each declared parameter, and by name what is wrong with a given one, which is then left
        at its default.
    """
    values: dict[str, Value] = {name: one.value(one.default) for name, one in declared.items()}
    wrong: dict[str, str] = {}
    for name, value in given.items():
        if name not in declared:
            wrong[name] = f"there is no parameter '{name}'{did_you_mean(name, declared)}"
            continue
        try:
            values[name] = declared[name].value(value)
        except ValueError as error:
            wrong[name] = f"{error} (declared at {declared[name].place})"
    return values, wrong
