"""A synthetic twin of the fly's brain: its size, its cell model, the names of its groups; made-up wiring.

The random part has log-normal numbers of synapses to and from each cell. Planted in it are three paths that
studies of the real brain report, each with as few cells as can carry it:

* taste cells (``sugar``) excite relays, and these the motor neurons of the proboscis (``MN9``), as
  Shiu et al. (2024, Nature 634:210) found in FlyWire's connectome,
* the relays also excite ``brakes``, which inhibit ``DNp09``,
* the descending cells ``DNp09`` (forward), ``DNa02`` (turn) and ``MDN`` (backward) are read by the gait.

So a finding about the twin is about these planted paths, not about flies.
"""

from __future__ import annotations

import numpy as np

from nrp_core import Network, Population, Projection

UNIT_MV, DELAY_MS = 0.275, 1.8  # of one synapse; Shiu et al. (2024)
SYNAPSES_PER_CELL = 108.86  # 15 091 983 edges for 138 639 cells, FlyWire v783
INHIBITORY = 0.35  # share of the cells
SPREAD = 0.9  # of the logarithm of the numbers of synapses
NAMED = {
    "sugar_left": 20, "sugar_right": 20, "relays": 60, "brakes": 20, "MN9_left": 1, "MN9_right": 1,
    "DNp09_left": 1, "DNp09_right": 1, "DNa02_left": 1, "DNa02_right": 1, "MDN": 4,
}  # fmt: skip
JOINED = {
    "sugar": ("sugar_left", "sugar_right"),
    "MN9": ("MN9_left", "MN9_right"),
    "DNp09": ("DNp09_left", "DNp09_right"),
    "DNa02": ("DNa02_left", "DNa02_right"),
}
SHARES = {"ascending": 2362 / 138639, "descending": 1303 / 138639}  # Dorkenwald et al. (2024)
PATHS = (
    # from, to, synapses of each pair; negative ones inhibit
    ("sugar", "relays", 12),
    ("relays", "MN9", 4),
    ("relays", "brakes", 8),
    ("brakes", "DNp09", -22),
)
CELL = {
    "v_rest": -52.0, "v_reset": -52.0, "v_thresh": -45.0, "tau_m": 20.0, "cm": 0.02, "tau_refrac": 2.2,
    "tau_syn_E": 5.0, "tau_syn_I": 5.0, "i_offset": 0.0,
}  # fmt: skip


Synapses = tuple[np.ndarray, np.ndarray, np.ndarray]
"""Source, target and weight (mV) of each."""


def twin(cells: int, seed: int) -> Network:
    """Return the twin.

    Args:
        cells: how many cells it has; the named ones are always there.
        seed: the seed of its wiring.
    """
    groups = _groups(cells)
    pre, post, weight = (
        np.concatenate(parts) for parts in zip(_paths(groups), _random(cells, seed), strict=True)
    )
    full = {name: np.broadcast_to(value, cells) for name, value in CELL.items()}
    brain = Population("brain", cells, "IF_curr_exp_frozen", full, {"v": full["v_rest"]})
    projections = []
    for receptor, mine in (("excitatory", weight > 0), ("inhibitory", weight < 0)):
        weights = weight[mine].astype(float)
        delays = np.broadcast_to(DELAY_MS, len(weights))
        projections.append(
            Projection(receptor, "brain", "brain", receptor, pre[mine], post[mine], weights, delays)
        )
    return Network({"brain": brain}, tuple(projections), groups)


def _groups(cells: int) -> dict[str, np.ndarray]:
    """Return the global ids of each group."""
    sizes = NAMED | {name: max(6, round(share * cells)) for name, share in SHARES.items()}
    ends = np.cumsum(list(sizes.values()))
    groups = {name: np.arange(end - size, end) for (name, size), end in zip(sizes.items(), ends, strict=True)}
    joined = {name: np.concatenate([groups[part] for part in parts]) for name, parts in JOINED.items()}
    return groups | joined


def _paths(groups: dict[str, np.ndarray]) -> Synapses:
    """Return the planted synapses, by source: all cells of a group with all of another."""
    parts = []
    for source, target, synapses in PATHS:
        pre, post = np.meshgrid(groups[source], groups[target], indexing="ij")
        parts.append((pre.ravel(), post.ravel(), np.full(pre.size, UNIT_MV * synapses)))
    pre, post, weight = (np.concatenate(column) for column in zip(*parts, strict=True))
    order = np.argsort(pre, kind="stable")
    return pre[order].astype(np.int32), post[order].astype(np.int32), weight[order].astype(np.float32)


def _random(cells: int, seed: int) -> Synapses:
    """Return the random synapses, by source; the named cells, which come first, have none of their own."""
    rng = np.random.default_rng(seed)
    first, total = sum(NAMED.values()), round(SYNAPSES_PER_CELL * cells)
    out, into = rng.lognormal(0.0, SPREAD, cells - first), rng.lognormal(0.0, SPREAD, cells)
    each = np.arange(cells, dtype=np.int32)
    pre = np.repeat(each[first:], rng.multinomial(total, out / out.sum()))
    post = rng.permutation(np.repeat(each, rng.multinomial(total, into / into.sum())))
    sign = np.where(rng.random(cells) < INHIBITORY, -1.0, 1.0).astype(np.float32)
    return pre, post, sign[pre] * np.float32(UNIT_MV) * rng.geometric(0.28, total).astype(np.float32)
