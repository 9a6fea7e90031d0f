"""Random numbers of compiled code without a stored generator: a hash of a key and a count.

The hash is the mixer of SplitMix64 (Steele et al. 2014, OOPSLA).
"""

from __future__ import annotations

from typing import Any, Final

import numpy as np
import numpy.typing as npt

from nrp_core._support.arrays import FloatArray
from nrp_core._support.jit import jit

GOLDEN: Final = np.uint64(0x9E3779B97F4A7C15)
"""The distance of two numbers that are hashed."""
_FIRST: Final = np.uint64(0xBF58476D1CE4E5B9)
_SECOND: Final = np.uint64(0x94D049BB133111EB)
_S30, _S27, _S31, _S11 = np.uint64(30), np.uint64(27), np.uint64(31), np.uint64(11)


def _mixed(x: Any) -> Any:
    """Return a pseudorandom bijection of 64 bits, of a number or of each in an array."""
    x = (x ^ (x >> _S30)) * _FIRST
    x = (x ^ (x >> _S27)) * _SECOND
    return x ^ (x >> _S31)


mixed = jit(_mixed)


@jit
def uniform(synapse: Any) -> float:
    """Return the next number of the stream of a synapse, from 0 to below 1."""
    number = np.uint64(synapse.stream) + GOLDEN
    synapse.stream = np.int64(number)
    return float(mixed(number) >> _S11) * 2.0**-53


@jit
def uniform_at(stream: float, step: int) -> float:
    """Return the number of a stream, a whole number below 2**53, at a step; from 0 to below 1."""
    return float(mixed(np.uint64(stream) + GOLDEN * np.uint64(step)) >> _S11) * 2.0**-53


def streams(n: int, seed: int) -> FloatArray:
    """Return different streams for n cells, for :func:`uniform_at`."""
    of_seed = _mixed(np.array([seed], np.uint64))
    found: FloatArray = (_mixed(np.arange(n, dtype=np.uint64) ^ of_seed) >> _S11).astype(float)
    return found


def begin_streams(synapses: npt.NDArray[Any], seed: int) -> None:
    """Begin the stream of each synapse for a seed; before, ``stream`` is the number of the synapse."""
    of_seed = _mixed(np.array([seed], np.uint64))
    synapses["stream"] = _mixed(synapses["stream"].astype(np.uint64) ^ of_seed).astype(np.int64)
