"""The pairs of nodes that a connection rule of NEST connects."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from nrp_core._support.arrays import IntArray
from nrp_core.errors import NetworkError, did_you_mean

RULES = (
    "all_to_all", "one_to_one", "fixed_indegree", "fixed_outdegree", "fixed_total_number",
    "pairwise_bernoulli",
)  # fmt: skip


def pairs(
    rule: Mapping[str, Any], n_pre: int, n_post: int, random: np.random.RandomState, *, same: bool
) -> tuple[IntArray, IntArray]:
    """Return indices of sources and targets, one pair per synapse.

    Args:
        rule: its name and settings, as ``conn_spec``.
        n_pre: number of sources.
        n_post: number of targets.
        random: the random generator.
        same: whether sources are the targets, for rules without autapses.

    Raises:
        NetworkError: the rule is unknown, or the numbers do not fit.
    """
    name = str(rule.get("rule", "all_to_all"))
    if name not in RULES:
        raise NetworkError(f"nest: the connection rule '{name}' is not supported{did_you_mean(name, RULES)}")
    autapses = bool(rule.get("autapses", rule.get("allow_autapses", True))) or not same
    multapses = bool(rule.get("multapses", rule.get("allow_multapses", True)))
    if name == "one_to_one":
        if n_pre != n_post:
            raise NetworkError(
                f"nest: one_to_one needs equal numbers of sources and targets, not {n_pre} and {n_post}"
            )
        return np.arange(n_pre), np.arange(n_pre)
    if name in ("fixed_indegree", "fixed_outdegree"):
        inward = name == "fixed_indegree"
        degree = int(rule["indegree" if inward else "outdegree"])
        far, near = (n_pre, n_post) if inward else (n_post, n_pre)
        drawn = _degree(degree, far, near, random, autapses=autapses, multapses=multapses)
        return drawn if inward else drawn[::-1]
    if name == "fixed_total_number":
        total = int(rule["N"])
        return random.randint(0, n_pre, total), random.randint(0, n_post, total)
    post, pre = np.divmod(np.arange(n_pre * n_post), max(n_pre, 1))  # target by target, as NEST
    chosen = np.ones(len(pre), bool) if autapses else pre != post
    if name == "pairwise_bernoulli":
        chosen &= random.uniform(size=len(pre)) < float(rule["p"])
    return pre[chosen], post[chosen]


def _degree(
    degree: int, far: int, near: int, random: np.random.RandomState, *, autapses: bool, multapses: bool
) -> tuple[IntArray, IntArray]:
    drawn = []
    for i in range(near):
        choices = np.arange(far) if autapses else np.delete(np.arange(far), i)
        if not multapses and degree > len(choices):
            raise NetworkError(f"nest: cannot draw {degree} different nodes from {len(choices)}")
        drawn.append(random.choice(choices, degree, replace=multapses))
    return np.concatenate([np.empty(0, np.int64), *drawn]), np.repeat(np.arange(near), degree)
