"""The primitives of a backend, for many brains at once."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from itertools import pairwise
from typing import Any

import numpy as np

from nrp_core._support.arrays import IntArray
from nrp_core.brain.spikes import Spikes, SynapticEvents
from nrp_core.simulation import Failures, note_failure


class Engines:
    """Calls the primitives of one brain after the other; a backend may override this with a faster class."""

    def inject(
        self, brains: Sequence[Any], counts: IntArray, events: SynapticEvents, kinds: IntArray
    ) -> Failures:
        """Deliver events.

        Args:
            brains: the brains.
            counts: how many events each source of each brain has, shape ``(brains, sources)``.
            events: all events, in this order; their receptor is ignored.
            kinds: 1 for each inhibitory event, else 0.
        """
        borders, failed = [0, *np.cumsum(counts).tolist()], Failures()
        for number, (first, last) in enumerate(pairwise(borders)):
            brain = number // counts.shape[1]
            if first < last and brain not in failed:
                own = slice(first, last)
                receptor = "inhibitory" if kinds[first] else "excitatory"
                part = SynapticEvents(
                    events.neurons[own], events.times_ms[own], events.weights[own], receptor
                )
                note_failure(failed, brain, partial(brains[brain]._do_inject, part))
        return failed

    def run(self, brains: Sequence[Any], times_ns: Sequence[int]) -> Failures:
        """Advance each brain to its time."""
        failed: Failures = {}
        for number, (brain, t_ns) in enumerate(zip(brains, times_ns, strict=True)):
            note_failure(failed, number, partial(brain._do_run_until, t_ns))
        return failed

    def take(self, brains: Sequence[Any]) -> tuple[IntArray, Spikes]:
        """Return and clear the new spikes: the index after the last spike of each brain, and all spikes."""
        parts = [Spikes.merged([brain._do_take_spikes()]) for brain in brains]
        neurons = np.concatenate([part.neurons for part in parts])
        return np.cumsum([*map(len, parts)]), Spikes(
            neurons, np.concatenate([part.times_ms for part in parts])
        )
