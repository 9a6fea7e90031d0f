"""The arguments of vector environments, checked; each mistake is one error."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from gymnasium.spaces import Dict
from gymnasium.vector import AutoresetMode

from nrp_core._support.arrays import BoolArray, FloatArray
from nrp_core.errors import ExperimentError, LifecycleError, did_you_mean


def mode_of(given: str | AutoresetMode) -> AutoresetMode:
    """Return an autoreset mode by its value.

    Raises:
        ExperimentError: there is no such mode.
    """
    values = [mode.value for mode in AutoresetMode]
    if isinstance(given, AutoresetMode):
        return given
    if given not in values:
        raise ExperimentError(
            f"autoreset_mode is one of {', '.join(values)}, not {given!r}{did_you_mean(str(given), values)}"
        )
    return AutoresetMode(given)


def require_number(name: str, given: Any, least: int) -> None:
    """Refuse a number of copies or threads that is not a whole number, or too low.

    Raises:
        ExperimentError: as said.
    """
    if not isinstance(given, int | np.integer) or isinstance(given, bool) or given < least:
        raise ExperimentError(f"{name} is a whole number from {least} on, not {given!r}")


def seeds_of(seed: int | Sequence[int | None] | None, copies: int) -> list[int | None]:
    """Return the seed of each copy; None: the copy continues the sequence of its last seed.

    Raises:
        ExperimentError: there are more or fewer seeds than copies.
    """
    if seed is None:
        return [None] * copies
    if isinstance(seed, int | np.integer):
        return [int(seed) + number for number in range(copies)]
    if len(seed) != copies:
        raise ExperimentError(f"{len(seed)} seeds for {copies} copies")
    return [None if one is None else int(one) for one in seed]


def masked(options: dict[str, Any] | None, copies: int) -> list[int]:
    """Return the numbers of the copies to reset: all, or those in ``options["reset_mask"]``.

    Raises:
        ExperimentError: the mask is not an array of a truth value for each copy, or all are False.
    """
    if options is None or "reset_mask" not in options:
        return list(range(copies))
    mask = options["reset_mask"]
    if (
        not isinstance(mask, np.ndarray)
        or mask.shape != (copies,)
        or mask.dtype != np.bool_
        or not mask.any()
    ):
        raise ExperimentError(
            f"reset_mask is an array of {copies} truth values, at least one of them True, not {mask!r:.80}"
        )
    numbers: list[int] = np.flatnonzero(mask).tolist()
    return numbers


def rows_of(actions: Mapping[str, Any], space: Dict) -> dict[str, FloatArray]:
    """Return the actions of all copies, a row for each.

    Raises:
        ExperimentError: one is missing, or has another shape.
    """
    found: dict[str, FloatArray] = {}
    for name, one in space.spaces.items():
        if name not in actions:
            raise ExperimentError(f"there is no action for '{name}'; it is {one}")
        rows = np.asarray(actions[name], np.float64)
        if rows.shape != one.shape:
            raise ExperimentError(f"the action '{name}' has the shape {one.shape}, not {rows.shape}")
        found[name] = rows
    return found


def require_going(over: BoolArray, mode: AutoresetMode) -> None:
    """Refuse a step of copies at their end if they are not reset by it.

    Raises:
        LifecycleError: as said.
    """
    if mode is AutoresetMode.DISABLED and over.any():
        numbers = ", ".join(map(str, np.flatnonzero(over)))
        mask = 'options={"reset_mask": ...}'
        raise LifecycleError(f"the episodes of these copies are over: {numbers}; reset them with {mask}")
