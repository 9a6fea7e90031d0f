"""Values that are drawn or computed for each node or synapse, as by ``nest.random`` and ``nest.math``."""

from __future__ import annotations

import operator
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import ModuleType
from typing import Any

import numpy as np

from nrp_core.brain import FloatArray
from nrp_core.errors import NetworkError, did_you_mean


@dataclass(frozen=True)
class Places:
    """The nodes or synapses for which a parameter is evaluated.

    Args:
        n: their number.
        random: the random generator.
        positions: of the nodes, shape ``(n, dimensions)``; None without positions.
        displacement: from the source to the target of each synapse, shape ``(n, dimensions)``.
        sources: positions of the sources of synapses.
        targets: positions of the targets of synapses.
    """

    n: int
    random: np.random.RandomState
    positions: FloatArray | None = None
    displacement: FloatArray | None = None
    sources: FloatArray | None = None
    targets: FloatArray | None = None

    def of(self, what: str) -> FloatArray:
        """Return positions or displacements.

        Raises:
            NetworkError: the nodes have none.
        """
        found: FloatArray | None = getattr(self, what)
        if found is None:
            raise NetworkError(
                "nest.spatial: the parameter needs nodes with positions: nest.Create(..., positions=...)"
            )
        return found


class Parameter:
    """A value for each node or synapse; arithmetic and comparisons with numbers and others are possible.

    Args:
        evaluate: returns the values at given places, shape ``(n,)``.
    """

    def __init__(self, evaluate: Callable[[Places], Any]) -> None:
        self.evaluate = evaluate

    def at(self, places: Places) -> FloatArray:
        """Return the values at places, shape ``(n,)``."""
        return np.broadcast_to(np.asarray(self.evaluate(places), float), (places.n,)).copy()

    def GetValue(self) -> float:  # noqa: N802 - NEST's name
        """Return one value."""
        return float(self.at(Places(1, np.random.RandomState()))[0])

    def __neg__(self) -> Parameter:
        return _combined(operator.mul, self, -1.0)


_OPERATORS = ("add", "sub", "mul", "truediv", "pow", "mod", "lt", "le", "gt", "ge")


def _combined(function: Callable[..., Any], *parts: Any) -> Parameter:
    """Return a function of parameters and numbers as a parameter."""
    return Parameter(
        lambda places: function(
            *(one.evaluate(places) if isinstance(one, Parameter) else one for one in parts)
        )
    )


def _add_operators() -> None:
    for name in _OPERATORS:
        function = getattr(operator, name)
        setattr(Parameter, f"__{name}__", lambda self, other, of=function: _combined(of, self, other))
        if name in ("add", "sub", "mul", "truediv", "pow"):
            setattr(Parameter, f"__r{name}__", lambda self, other, of=function: _combined(of, other, self))


_add_operators()


# -- nest.random


def uniform(min: float = 0.0, max: float = 1.0, **other: float) -> Parameter:  # noqa: A002 - NEST's names
    """Return a uniform distribution; ``low`` and ``high`` are its bounds in NEST 2."""
    low, high = other.get("low", min), other.get("high", max)
    return Parameter(lambda places: places.random.uniform(low, high, places.n))


def uniform_int(max: int) -> Parameter:  # noqa: A002 - NEST's name
    """Return a uniform distribution of whole numbers from 0 to below ``max``."""
    return Parameter(lambda places: places.random.randint(0, int(max), places.n))


def normal(mean: float = 0.0, std: float = 1.0) -> Parameter:
    """Return a normal distribution."""
    return Parameter(lambda places: places.random.normal(mean, std, places.n))


def lognormal(mean: float = 0.0, std: float = 1.0) -> Parameter:
    """Return a lognormal distribution; mean and deviation are those of the logarithm."""
    return Parameter(lambda places: places.random.lognormal(mean, std, places.n))


def exponential(beta: float = 1.0) -> Parameter:
    """Return an exponential distribution of mean ``beta``."""
    return Parameter(lambda places: places.random.exponential(beta, places.n))


def is_random(value: Any) -> bool:
    """Return whether a value is evaluated for each node or synapse."""
    return isinstance(value, Parameter) or (isinstance(value, Mapping) and "distribution" in value)


def drawn(value: Any, places: Places) -> FloatArray:
    """Return the values of a parameter, also of a distribution in the notation of NEST 2.

    Raises:
        NetworkError: the distribution is unknown.
    """
    if isinstance(value, Parameter):
        return value.at(places)
    kind = str(value["distribution"])
    numbers = {key: float(one) for key, one in value.items() if key != "distribution"}
    known: dict[str, Callable[[], Parameter]] = {
        "uniform": lambda: uniform(numbers.get("low", 0.0), numbers.get("high", 1.0)),
        "normal": lambda: normal(numbers.get("mu", 0.0), numbers.get("sigma", 1.0)),
        "lognormal": lambda: lognormal(numbers.get("mu", 0.0), numbers.get("sigma", 1.0)),
        "exponential": lambda: exponential(1.0 / numbers.get("lambda", 1.0)),
    }
    root = kind.removesuffix("_clipped").removesuffix("_clipped_to_boundary")
    if root not in known:
        raise NetworkError(f"nest: the distribution '{kind}' is not supported{did_you_mean(root, known)}")
    return np.clip(known[root]().at(places), numbers.get("low", -np.inf), numbers.get("high", np.inf))


# -- nest.math, nest.logic


def redraw(parameter: Parameter, min: float, max: float) -> Parameter:  # noqa: A002 - NEST's names
    """Return a parameter whose values outside bounds are drawn again.

    Raises:
        NetworkError: 1000 draws leave values outside.
    """

    def evaluate(places: Places) -> FloatArray:
        values = parameter.at(places)
        for _ in range(1000):
            outside = (values < min) | (values > max)
            if not outside.any():
                return values
            values[outside] = parameter.at(places)[outside]
        raise NetworkError(f"nest.math.redraw: no value between {min:g} and {max:g} in 1000 draws")

    return Parameter(evaluate)


def _module(name: str, **content: Any) -> ModuleType:
    made = ModuleType(name)
    vars(made).update(content)
    return made


def parameter_modules() -> dict[str, ModuleType]:
    """Return ``nest.random``, ``nest.math``, ``nest.logic`` and ``nest.spatial_distributions``."""
    return {
        "random": _module(
            "nest.random", uniform=uniform, uniform_int=uniform_int, normal=normal, lognormal=lognormal,
            exponential=exponential,
        ),
        "math": _module(
            "nest.math", exp=lambda x: _combined(np.exp, x), sin=lambda x: _combined(np.sin, x),
            cos=lambda x: _combined(np.cos, x), min=lambda x, value: _combined(np.minimum, x, value),
            max=lambda x, value: _combined(np.maximum, x, value), redraw=redraw,
        ),
        "logic": _module(
            "nest.logic", conditional=lambda condition, yes, no: _combined(np.where, condition, yes, no)
        ),
        "spatial_distributions": _module(
            "nest.spatial_distributions",
            exponential=lambda x, beta=1.0: _combined(lambda d: np.exp(-d / beta), x),
            gaussian=_gaussian, gaussian2D=_gaussian2d, gamma=_gamma,
        ),
    }  # fmt: skip


def _gaussian(x: Any, mean: float = 0.0, std: float = 1.0) -> Parameter:
    return _combined(lambda d: np.exp(-((d - mean) ** 2) / (2 * std**2)), x)


def _gaussian2d(
    x: Any, y: Any, mean_x: float = 0.0, mean_y: float = 0.0, std_x: float = 1.0, std_y: float = 1.0,
    rho: float = 0.0,
) -> Parameter:  # fmt: skip
    def density(first: FloatArray, second: FloatArray) -> FloatArray:
        a, b = (first - mean_x) / std_x, (second - mean_y) / std_y
        return np.exp(-(a**2 + b**2 - 2 * rho * a * b) / (2 * (1 - rho**2)))

    return _combined(density, x, y)


def _gamma(x: Any, kappa: float = 1.0, theta: float = 1.0) -> Parameter:
    from math import gamma

    return _combined(lambda d: d ** (kappa - 1) / (theta**kappa * gamma(kappa)) * np.exp(-d / theta), x)
