"""The ``infos`` of vector environments: for each key an array, and a mask of the copies that it is about."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from nrp_lab.gym.agent_run import AgentRun

Infos = dict[str, Any]


def infos_of(copies: Sequence[AgentRun], chosen: Sequence[int]) -> Infos:
    """Return time and criteria of some copies after a step; empty if there are none.

    Whether a criterion is met is True, False or None, so these arrays have the type ``object``.
    """
    if not len(chosen):
        return {}
    infos = times_of(copies, chosen)
    criteria: Infos = {}
    for name in copies[chosen[0]].decided:
        met = np.full(len(copies), None, object)
        for number in chosen:
            met[number] = copies[number].decided[name]
        criteria |= {name: met, f"_{name}": infos["_t_s"].copy()}
    return infos | {"criteria": criteria, "_criteria": infos["_t_s"].copy()}


def times_of(copies: Sequence[AgentRun], chosen: Sequence[int], infos: Infos | None = None) -> Infos:
    """Return the times of some copies, s, added to those in ``infos``."""
    infos = {} if infos is None else infos
    times = infos.setdefault("t_s", np.zeros(len(copies)))
    mask = infos.setdefault("_t_s", np.zeros(len(copies), np.bool_))
    for number in chosen:
        times[number], mask[number] = copies[number].run.now_s, True
    return infos


def final_infos(copies: Sequence[AgentRun], ended: Sequence[int], seen: dict[str, Any]) -> Infos:
    """Return the last observations and infos of copies that are reset in the step of their end."""
    mask = np.zeros(len(copies), np.bool_)
    mask[ended] = True
    last = np.full(len(copies), None, object)
    for number in ended:
        last[number] = {name: rows[number].copy() for name, rows in seen.items()}
    found = {"final_obs": last, "final_info": infos_of(copies, ended)}
    return found | {f"_{name}": mask.copy() for name in found}


def joined(parts: Sequence[tuple[int, Infos]]) -> Infos:
    """Return the infos of several groups of copies as one.

    Args:
        parts: the number of copies of each group and its infos; what a group does not have is masked there.
    """
    found: Infos = {}
    for name in dict.fromkeys(name for _, infos in parts for name in infos):
        example = next(infos[name] for _, infos in parts if name in infos)
        if isinstance(example, dict):
            found[name] = joined([(size, infos.get(name, {})) for size, infos in parts])
        else:
            nothing = None if example.dtype == np.dtype(object) else 0
            found[name] = np.concatenate(
                [infos.get(name, np.full(size, nothing, example.dtype)) for size, infos in parts]
            )
    return found
