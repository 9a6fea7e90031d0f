"""The rules by which ``Connect`` chooses pairs of nodes, with and without positions."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from nrp_core.brain import BoolArray, FloatArray, IntArray
from nrp_core.errors import NetworkError, did_you_mean
from nrp_pynest.parameters import Parameter, Places
from nrp_pynest.spatial import Layer, Mask, inside_layer, mask_of

_PART = 1_000_000
"""Pairs that are considered at a time."""


@dataclass(frozen=True)
class Ends:
    """The nodes between which a rule chooses pairs.

    Args:
        n_pre: number of sources.
        n_post: number of targets.
        are_same: whether the sources are the targets, for rules without autapses.
        pre: the positions of sources; None without.
        post: the positions of targets.
        layer: knows the way between positions.
    """

    n_pre: int
    n_post: int
    are_same: bool
    pre: FloatArray | None = None
    post: FloatArray | None = None
    layer: Layer | None = None

    def places(self, i: IntArray, j: IntArray, random: np.random.RandomState) -> Places:
        """Return where the synapses from sources ``i`` to targets ``j`` are."""
        if self.pre is None or self.post is None or self.layer is None:
            return Places(len(i), random)
        sources, targets = self.pre[i], self.post[j]
        way = self.layer.displacement(sources, targets)
        return Places(len(i), random, targets, way, sources, targets)


@dataclass(frozen=True)
class Rule:
    """A connection rule with its settings, as ``conn_spec``."""

    settings: Mapping[str, Any]

    @property
    def name(self) -> str:
        """Its name."""
        return str(self.settings.get("rule", "all_to_all"))

    def allows(self, what: str) -> bool:
        """Return whether it allows ``autapses`` or ``multapses``."""
        return bool(self.settings.get(what, self.settings.get(f"allow_{what}", True)))

    @property
    def mask(self) -> Mask | None:
        """The region around a node within which it is connected."""
        given = self.settings.get("mask")
        return None if given is None else mask_of(given)


Pairs = tuple[IntArray, IntArray]
"""Indices of sources and targets, one pair per synapse."""


def pairs(settings: Mapping[str, Any], ends: Ends, random: np.random.RandomState) -> Pairs:
    """Return the synapses that a rule makes.

    Raises:
        NetworkError: the rule is unknown, or the numbers do not fit.
    """
    rule = Rule(settings)
    if rule.name not in _RULES:
        raise NetworkError(
            f"nest: the connection rule '{rule.name}' is not supported{did_you_mean(rule.name, _RULES)}"
        )
    for name in settings.keys() - _SETTINGS:
        raise NetworkError(f"nest: '{name}' of conn_spec is not supported{did_you_mean(name, _SETTINGS)}")
    return _RULES[rule.name](rule, ends, random)


def _one_to_one(_rule: Rule, ends: Ends, _random: np.random.RandomState) -> Pairs:
    if ends.n_pre != ends.n_post:
        raise NetworkError(
            f"nest: one_to_one needs equal numbers of sources and targets, not {ends.n_pre} and {ends.n_post}"
        )
    return np.arange(ends.n_pre), np.arange(ends.n_pre)


def _degree(inward: bool) -> Callable[[Rule, Ends, np.random.RandomState], Pairs]:
    def rule_of_degree(rule: Rule, ends: Ends, random: np.random.RandomState) -> Pairs:
        given = rule.settings["indegree" if inward else "outdegree"]
        far, near = (ends.n_pre, ends.n_post) if inward else (ends.n_post, ends.n_pre)
        is_plain = rule.mask is None and "p" not in rule.settings and not isinstance(given, Parameter)
        if is_plain and rule.allows("multapses"):
            drawn = _with_multapses(int(given), far, near, random, skip_own=_skips_own(rule, ends))
        else:
            drawn = _chosen_for_each(rule, ends, random, inward=inward, given=given)
        return drawn if inward else drawn[::-1]

    return rule_of_degree


def _skips_own(rule: Rule, ends: Ends) -> bool:
    return ends.are_same and not rule.allows("autapses")


def _with_multapses(
    degree: int, far: int, near: int, random: np.random.RandomState, *, skip_own: bool
) -> Pairs:
    own = np.arange(near)
    drawn = random.randint(0, max(far - skip_own, 1), (near, degree))
    if skip_own:
        drawn += drawn >= own[:, None]
    return drawn.ravel(), np.repeat(own, degree)


def _chosen_for_each(
    rule: Rule, ends: Ends, random: np.random.RandomState, *, inward: bool, given: Any
) -> Pairs:
    """Return the pairs of rules that look at all candidates of each node: near one by one, far chosen."""
    near = ends.n_post if inward else ends.n_pre
    degrees = given.at(Places(near, random)).astype(int) if isinstance(given, Parameter) else [given] * near
    chosen: list[Any] = []
    for k, degree in enumerate(degrees):
        candidates, chance = _candidates(rule, ends, random, k, inward=inward)
        degree = int(degree)
        enough = len(candidates) if rule.allows("multapses") else (chance > 0).sum()
        if degree and (not len(candidates) or (degree > enough and not rule.allows("multapses"))):
            raise NetworkError(f"nest: cannot draw {degree} different nodes from {len(candidates)}")
        weights = None if (chance == 1).all() else chance / chance.sum()
        chosen.append(random.choice(candidates, degree, rule.allows("multapses"), weights) if degree else [])
    counts = [len(one) for one in chosen]
    return np.concatenate([np.empty(0, np.int64), *chosen]).astype(np.int64), np.repeat(
        np.arange(near), counts
    )


def _candidates(
    rule: Rule, ends: Ends, random: np.random.RandomState, k: int, *, inward: bool
) -> tuple[IntArray, FloatArray]:
    """Return the nodes that one node may be connected to, and the probability of each."""
    far = np.arange(ends.n_pre if inward else ends.n_post)
    if _skips_own(rule, ends):
        far = far[far != k]
    here = np.full(len(far), k)
    i, j = (far, here) if inward else (here, far)
    chosen = _within(rule.mask, ends, i, j, from_target=inward)
    return far[chosen], _chance(rule, ends, i[chosen], j[chosen], random)


def _chance(rule: Rule, ends: Ends, i: IntArray, j: IntArray, random: np.random.RandomState) -> FloatArray:
    p = rule.settings.get("p", 1.0)
    if isinstance(p, Parameter):
        return np.clip(p.at(ends.places(i, j, random)), 0.0, 1.0)
    return np.full(len(i), float(p))


def _within(mask: Mask | None, ends: Ends, i: IntArray, j: IntArray, *, from_target: bool) -> BoolArray:
    if mask is None:
        return np.ones(len(i), bool)
    if ends.pre is None or ends.post is None or ends.layer is None:
        raise NetworkError("nest.Connect: a mask needs nodes with positions on both sides")
    start, end = (ends.post[j], ends.pre[i]) if from_target else (ends.pre[i], ends.post[j])
    return inside_layer(mask, ends.layer, start, end)


def _total(rule: Rule, ends: Ends, random: np.random.RandomState) -> Pairs:
    total = int(rule.settings["N"])
    if rule.allows("multapses") and not _skips_own(rule, ends):
        return random.randint(0, ends.n_pre, total), random.randint(0, ends.n_post, total)
    every = np.arange(ends.n_pre * ends.n_post)
    if _skips_own(rule, ends):
        every = every[every % ends.n_pre != every // ends.n_pre]
    chosen = random.choice(every, total, rule.allows("multapses"))
    return chosen % ends.n_pre, chosen // ends.n_pre


def _each(rule: Rule, ends: Ends, random: np.random.RandomState) -> Pairs:
    """Return all pairs, or each with its probability, target by target, as NEST."""
    parts = list(_parts(rule, ends, random))
    sources, targets = (np.concatenate([np.empty(0, np.int64), *part]) for part in zip(*parts, strict=True))
    if rule.name == "symmetric_pairwise_bernoulli":
        return np.append(sources, targets), np.append(targets, sources)
    return sources, targets


def _parts(rule: Rule, ends: Ends, random: np.random.RandomState) -> Iterator[Pairs]:
    rows = max(1, _PART // max(ends.n_pre, 1))
    symmetric = rule.name == "symmetric_pairwise_bernoulli"
    for first in range(0, max(ends.n_post, 1), rows):
        count = min(rows, ends.n_post - first)
        j, i = np.divmod(np.arange(ends.n_pre * count), max(ends.n_pre, 1))
        j += first
        chosen = np.ones(len(i), bool)
        if _skips_own(rule, ends) or symmetric:
            chosen = i < j if symmetric else i != j
        from_target = bool(rule.settings.get("use_on_source", False))
        if rule.mask is not None:
            chosen &= _within(rule.mask, ends, i, j, from_target=from_target)
        i, j = i[chosen], j[chosen]
        if "p" in rule.settings:
            kept = random.uniform(size=len(i)) < _chance(rule, ends, i, j, random)
            i, j = i[kept], j[kept]
        yield i, j


_RULES: Mapping[str, Callable[[Rule, Ends, np.random.RandomState], Pairs]] = {
    "all_to_all": _each,
    "pairwise_bernoulli": _each,
    "symmetric_pairwise_bernoulli": _each,
    "one_to_one": _one_to_one,
    "fixed_indegree": _degree(inward=True),
    "fixed_outdegree": _degree(inward=False),
    "fixed_total_number": _total,
}
_SETTINGS = frozenset(
    {
        "rule", "p", "indegree", "outdegree", "N", "mask", "use_on_source", "autapses", "multapses",
        "allow_autapses", "allow_multapses", "allow_oversized_mask", "make_symmetric",
    }
)  # fmt: skip
