"""The parameters of an experiment's brain script and transfer functions: checked, and with their values."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from nrp_core.experiment.making.maker import maker_of
from nrp_core.experiment.model.collector import Collector
from nrp_core.experiment.model.experiment import Experiment
from nrp_core.experiment.model.tree import Key
from nrp_core.findings import Code, Finding, Level
from nrp_core.parameters import Declared, Parameter, Value, fitting


@dataclass(frozen=True, slots=True)
class ParameterValue:
    """A parameter of a script and its value in an experiment.

    Args:
        parameter: its declaration.
        value: in the declared unit.
        set_by: where the experiment sets it, such as ``experiment.yaml:5``; None: it is the default.
    """

    parameter: Parameter
    value: Value
    set_by: str | None = None

    @classmethod
    def of_data(cls, name: str, data: Mapping[str, Any]) -> ParameterValue:
        """Return the parameter that :meth:`as_data` described."""
        file = data["file"] and Path(data["file"])
        about = {key: data[key] for key in ("default", "unit", "low", "high", "doc", "line")}
        by_whom = data.get("set_by", "the experiment" if data["value"] != data["default"] else None)
        return cls(Parameter(name, path=file, **about), data["value"], by_whom)

    def __str__(self) -> str:
        """Return value, range and description in one line."""
        about = [self.parameter.range, self.parameter.doc]
        if self.set_by is not None:
            about.insert(0, f"default {self.parameter.shown(self.parameter.default)}")
        details = "; ".join(filter(None, about))
        return f"{self.parameter.name} = {self.parameter.shown(self.value)}" + (
            f"  ({details})" if details else ""
        )

    def as_data(self) -> dict[str, Any]:
        """Return it as plain data for JSON."""
        one = self.parameter
        return {
            "value": self.value, "default": one.default, "unit": one.unit, "low": one.low, "high": one.high,
            "doc": one.doc, "file": one.path and one.path.name, "line": one.line, "set_by": self.set_by,
        }  # fmt: skip


@dataclass(frozen=True, slots=True)
class Parameters:
    """All parameters of an experiment, by name.

    Args:
        brain: those of its brain script.
        functions: those of its transfer functions.
    """

    brain: Mapping[str, ParameterValue] = field(default_factory=dict)
    functions: Mapping[str, ParameterValue] = field(default_factory=dict)

    def as_data(self) -> dict[str, dict[str, Any]]:
        """Return them as plain data for JSON."""
        sides = {"brain": self.brain, "functions": self.functions}
        return {side: {name: one.as_data() for name, one in all_.items()} for side, all_ in sides.items()}


def with_parameters(experiment: Experiment, collector: Collector) -> tuple[Experiment, Parameters]:
    """Check the parameters of an experiment without executing a script.

    Returns:
        the experiment without the values that do not fit, which are findings, and all parameters.
    """
    maker, brain = maker_of(experiment), experiment.brain
    of_brain = _checked(
        maker.brain_parameters(experiment), brain.parameters, collector, "brain", "parameters"
    )
    of_functions = _checked(
        maker.function_parameters(experiment),
        experiment.function_parameters,
        collector,
        "function_parameters",
    )
    kept = {
        "brain": brain.model_copy(update={"parameters": _given(of_brain)}),
        "function_parameters": _given(of_functions),
    }
    return experiment.model_copy(update=kept), Parameters(of_brain, of_functions)


def _checked(
    declared: Declared, given: Mapping[str, object], collector: Collector, *keys: Key
) -> dict[str, ParameterValue]:
    for mistake in declared.mistakes:
        with collector.during(Code.NRP289):
            raise mistake
    for parameter in () if declared.mistakes else declared.unused:
        message = f"nothing reads the parameter '{parameter.name}': every value gives the same result"
        where = Finding(Code.NRP318, message, Level.WARNING, parameter.path, parameter.line)
        collector.findings.append(where)
    values, wrong = fitting(declared.parameters, given)
    unread = {mistake.path for mistake in declared.mistakes}
    for name, message in wrong.items():
        if name in declared.parameters or not unread:  # an unreadable declaration may be the one for it
            collector.add(Code.NRP288, message, *keys, name)
    return {
        name: ParameterValue(
            one,
            values[name],
            str(collector.source.place_of(*keys, name)) if name in given and name not in wrong else None,
        )
        for name, one in declared.parameters.items()
    }


def _given(parameters: Mapping[str, ParameterValue]) -> dict[str, Value]:
    return {name: one.value for name, one in parameters.items() if one.set_by is not None}
