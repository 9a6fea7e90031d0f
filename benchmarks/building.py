"""The cost of building a network of 15.6 million synapses from a PyNN script.

The network is Brunel's (J. Comput. Neurosci. 8:183, 2000): 10 000 excitatory and 2 500 inhibitory cells,
each with 1 250 inputs. Every case runs in a process of its own, so that its peak of memory is its own; CPU
time includes the digest that a backend takes, but not the import of Python packages.

    python benchmarks/building.py
    python benchmarks/building.py --cases "fixed number" --json
"""

from __future__ import annotations

import argparse
import json
import resource
import subprocess
import sys
import time
from collections.abc import Callable
from types import ModuleType
from typing import Any

from conditions import print_conditions

N_EXCITATORY, N_INHIBITORY, SHARE = 10_000, 2_500, 0.1

Connector = Callable[[ModuleType, int, int], Any]

CONNECTORS: dict[str, Connector] = {
    "FixedNumberPre": lambda sim, n_pre, _: sim.FixedNumberPreConnector(round(SHARE * n_pre)),
    "FixedNumberPost": lambda sim, _, n_post: sim.FixedNumberPostConnector(round(SHARE * n_post)),
    "FixedTotalNumber": lambda sim, n, m: sim.FixedTotalNumberConnector(round(SHARE * n * m)),
    "FixedProbability": lambda sim, *_: sim.FixedProbabilityConnector(SHARE),
}
CASES = {
    "fixed number": ("FixedNumberPre", ()),
    "fixed number, random weights": ("FixedNumberPre", ("weight",)),
    "fixed number, random weights and delays": ("FixedNumberPre", ("weight", "delay")),
    "fixed number of targets": ("FixedNumberPost", ()),
    "fixed total": ("FixedTotalNumber", ()),
    "probability": ("FixedProbability", ()),
    "probability, random weights and delays": ("FixedProbability", ("weight", "delay")),
}


def built(sim: ModuleType, connector: Connector, drawn: tuple[str, ...]) -> Any:
    """Build the network and return it."""
    sim.setup(timestep=0.1)
    populations = {
        "excitatory": sim.Population(N_EXCITATORY, sim.IF_curr_exp(), label="excitatory"),
        "inhibitory": sim.Population(N_INHIBITORY, sim.IF_curr_exp(), label="inhibitory"),
    }
    delay = sim.RandomDistribution("uniform", low=0.5, high=2.5) if "delay" in drawn else 1.5
    for receptor, (low, high) in {"excitatory": (0.05, 0.15), "inhibitory": (-0.75, -0.25)}.items():
        weight = sim.RandomDistribution("uniform", low=low, high=high) if "weight" in drawn else high
        pre = populations[receptor]
        for post in populations.values():
            synapse = sim.StaticSynapse(weight=weight, delay=delay)
            sim.Projection(pre, post, connector(sim, pre.size, post.size), synapse, receptor_type=receptor)
    return sim.network()


def measured(case: str) -> dict[str, Any]:
    """Build a case in this process."""
    from nrp_core.network.pynn import builder

    connector, drawn = CASES[case]
    sim = builder(seed=1)
    began = time.process_time()
    network = built(sim, CONNECTORS[connector], drawn)
    digest = network.digest
    return {
        "synapses": sum(projection.size for projection in network.projections),
        "cpu_s": time.process_time() - began,
        "peak_mb": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024,
        "digest": digest,
    }


def in_its_own_process(case: str) -> dict[str, Any]:
    done = subprocess.run(
        [sys.executable, __file__, "--here", case], stdout=subprocess.PIPE, text=True, check=True
    )
    found: dict[str, Any] = json.loads(done.stdout)
    return found


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--cases", nargs="+", choices=CASES, default=list(CASES))
    parser.add_argument("--json", action="store_true")
    parser.add_argument("--here", choices=CASES, help=argparse.SUPPRESS)
    asked = parser.parse_args()
    if asked.here:
        print(json.dumps(measured(asked.here)))
        return
    print_conditions()
    found = {case: in_its_own_process(case) for case in asked.cases}
    if asked.json:
        print(json.dumps(found, indent=2))
        return
    print(f"{'case':42s} {'synapses':>12s} {'CPU':>8s} {'peak':>8s}")
    for case, one in found.items():
        print(f"{case:42s} {one['synapses']:12,d} {one['cpu_s']:6.2f} s {one['peak_mb']:5.0f} MB")


if __name__ == "__main__":
    main()
