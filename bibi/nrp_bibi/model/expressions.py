"""The expression language: building blocks that are nested."""

from __future__ import annotations

from dataclasses import dataclass

from nrp_bibi.model.metamodel import Node, attribute, child, children
from nrp_bibi.model.values import DOTTED, NAME, NUMBER, PATH, TEXT


@dataclass(frozen=True, slots=True, kw_only=True)
class FlowExpression(Node, abstract=True):
    """An expression, evaluated each time the transfer function runs."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Constant(FlowExpression):
    """A number; without a decimal point it is an integer."""

    value: float = attribute(NUMBER)


@dataclass(frozen=True, slots=True, kw_only=True)
class ConstantString(FlowExpression):
    """A string."""

    value: str = attribute(TEXT)


@dataclass(frozen=True, slots=True, kw_only=True)
class SimulationStep(FlowExpression):
    """The simulation time in seconds."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ArgumentReference(FlowExpression):
    """A channel or local, or a property of one, such as the ``voltage`` of a device."""

    name: str = attribute(NAME)
    property: str | None = attribute(PATH, None)


@dataclass(frozen=True, slots=True, kw_only=True)
class Scale(FlowExpression):
    """A number times an expression."""

    factor: float = attribute(NUMBER)
    inner: FlowExpression = child(FlowExpression)


@dataclass(frozen=True, slots=True, kw_only=True)
class Operator(FlowExpression, abstract=True):
    """An operation on at least two operands, evaluated from the left."""

    operand: tuple[FlowExpression, ...] = children(FlowExpression, least=2)


@dataclass(frozen=True, slots=True, kw_only=True)
class Add(Operator):
    """The sum."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Subtract(Operator):
    """The first operand minus all others."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Multiply(Operator):
    """The product."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Divide(Operator):
    """The first operand divided by all others."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Min(Operator):
    """The minimum."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Max(Operator):
    """The maximum."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Argument(Node):
    """An argument of a call; without a name it is positional."""

    name: str | None = attribute(NAME, None)
    value: FlowExpression = child(FlowExpression)


@dataclass(frozen=True, slots=True, kw_only=True)
class Call(FlowExpression):
    """A call of a library function or message class, such as ``nrp.tf_lib.detect_red``."""

    type: str = attribute(DOTTED)
    argument: tuple[Argument, ...] = children(Argument)
