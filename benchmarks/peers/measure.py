"""The work of every child process of benchmarks/networks.py: measure a run, print the result as JSON."""

from __future__ import annotations

import argparse
import hashlib
import json
import resource
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

sys.path.insert(0, str(Path(__file__).parent))
import graphs

CHECKED_MS = 300.0
STEP_MS = 0.1


def arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser()
    parser.add_argument("model", choices=graphs.MODELS)
    parser.add_argument("--n", type=int, required=True)
    parser.add_argument("--weights", default="equal")
    parser.add_argument("--delays", default="equal")
    parser.add_argument("--duration", type=float, default=1000.0, help="ms, of each chunk")
    parser.add_argument("--chunks", type=int, default=3)
    parser.add_argument("--warm-up", type=float, default=CHECKED_MS)
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--mode", default="grid")
    return parser.parse_args()


def graph_of(chosen: argparse.Namespace) -> graphs.Graph:
    return graphs.make(chosen.model, chosen.n, weights=chosen.weights, delays=chosen.delays)


def digest(neurons: npt.ArrayLike, times_ms: npt.ArrayLike) -> str:
    """Return a hash of the spikes on the grid up to the time that is checked."""
    ids, steps = np.asarray(neurons, np.int64), np.rint(np.asarray(times_ms) / STEP_MS).astype(np.int64)
    chosen = steps <= round(CHECKED_MS / STEP_MS)
    order = np.lexsort((ids[chosen], steps[chosen]))
    spikes = np.stack([steps[chosen][order], ids[chosen][order]])
    return hashlib.blake2b(spikes.tobytes(), digest_size=8).hexdigest()


def chunks(run: Callable[[], object], n: int, duration_ms: float) -> list[float]:
    """Return CPU seconds per simulated second of n runs."""
    costs = []
    for _ in range(n):
        began = time.process_time()
        run()
        costs.append((time.process_time() - began) / duration_ms * 1e3)
    return costs


def report(**found: Any) -> None:
    found.setdefault("peak_mb", resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024)
    print(json.dumps(found))
