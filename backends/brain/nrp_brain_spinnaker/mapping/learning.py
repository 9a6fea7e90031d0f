"""Weight changes that plastic synapses lose, because the machine stores weights in steps."""

from __future__ import annotations

import numpy as np

from nrp_brain_spinnaker.host.wiring import Wires
from nrp_brain_spinnaker.options import SpinnakerOptions
from nrp_core.brain.network.limits import distinct
from nrp_core.brain.network.synapses import STDP


def lost_changes(part: Wires, options: SpinnakerOptions) -> str | None:
    """Return the changes of weights by a pair of spikes that are at most smaller than a step.

    A changed weight is rounded down to a step: an increase by less than a step is lost, a decrease by less
    than a step becomes a whole step.

    Args:
        part: a projection on the machine.
        options: the options of the user.
    """
    projection = part.projection
    if (
        projection.synapse_type != STDP
        or not projection.size
        or "A_plus" not in projection.synapse_parameters
    ):
        return None  # only the rule of pairs loses as much each time
    step = 1.0 / part.scale
    given = {name: float(distinct(values)[0]) for name, values in projection.synapse_parameters.items()}
    factor = 1.0 if part.factor is None else float(np.min(part.factor))
    low, high = abs(given["w_min"]) * factor, abs(given["w_max"]) * factor
    if projection.plasticity["weight_dependence"] == "MultiplicativeWeightDependence":
        most = high - low
    else:
        most = high if options.semantics == "pynn" else 1.0
    up, down = given["A_plus"] * most, given["A_minus"] * most
    lines = []
    if 0 < up < step:
        lines.append(f"a pair of spikes adds at most {up:.3g}, which is rounded to 0")
    if 0 < down < step:
        lines.append(f"a pair of spikes should subtract at most {down:.3g}, but subtracts a whole step")
    if not lines:
        return None
    return (
        f"projection '{projection.label}': its weights are stored in steps of {step:.3g}: "
        f"{'; '.join(lines)}; "
        "increase A_plus and A_minus, or the range of the weights"
    )
