"""The messages for capabilities that a backend lacks, if several modules refuse them.

Errors become findings of ``NRP216`` at the place in the experiment that needs the capability.
"""

from __future__ import annotations

from collections.abc import Iterable

from nrp_core.errors import CapabilityError, did_you_mean, nearest

SNAPSHOTS = "cannot save and restore its state"
SCENE_CHANGES = "cannot change its scene"
MODEL_MOVES = "cannot move models"
JOINT_CONTROL = "does not control joints"


def refusal(owner: object, lacking: str) -> CapabilityError:
    """Return the error for an operation that a brain or an engine does not have."""
    return CapabilityError(f"{type(owner).__name__} {lacking}")


# -- brains


def no_cells(backend: str, cell_type: str, population: str, valid: Iterable[str]) -> CapabilityError:
    """Return the error for a cell type that a brain backend does not have."""
    if cell_type == "EquationCell":
        return CapabilityError(
            f"{backend}, as it is set, has no cells that are given as equations (population '{population}'); "
            "'event' with a time grid has, e.g. `resolution: 0.1 ms`"
        )
    return _no_type(backend, f"cells of type {cell_type} (population '{population}')", cell_type, valid)


def other_step(backend: str, resolution_ms: float, step_ms: float, population: str) -> CapabilityError:
    """Return the error for cells whose equations are made for another step than that of the backend."""
    return CapabilityError(
        f"{backend} has a resolution of {resolution_ms:g} ms, and the cells of population '{population}' are "
        f"integrated in steps of {step_ms:g} ms: set `resolution: {step_ms:g} ms`"
    )


def no_synapses(backend: str, synapse_type: str, projection: str, valid: Iterable[str]) -> CapabilityError:
    """Return the error for a synapse type that a brain backend does not have."""
    if synapse_type == "EquationSynapse":
        return CapabilityError(
            f"{backend} has no synapses that are given as equations (projection '{projection}'); 'event' has"
        )
    return _no_type(backend, f"{synapse_type} synapses (projection '{projection}')", synapse_type, valid)


def no_voltages(backend: str, synapse_type: str, projection: str) -> CapabilityError:
    """Return the error for synapses that transmit voltages, on a brain backend whose synapses do not."""
    return CapabilityError(
        f"{backend}, as it is set, has no {synapse_type} synapses (projection '{projection}'), which "
        "transmit voltages; 'event' with a time grid has, e.g. `resolution: 0.1 ms`"
    )


def no_initial_synapses(backend: str, projection: str, given: Iterable[str]) -> CapabilityError:
    """Return the error for a brain backend whose synapses begin at rest."""
    return CapabilityError(
        f"{backend} begins with all synapses at rest; projection '{projection}' gives the initial values of "
        f"{_join_names(given, 'none')}, which 'event' takes"
    )


def no_rewiring(backend: str, projection: str) -> CapabilityError:
    """Return the error for a brain backend whose synapses neither form nor vanish while it runs."""
    return CapabilityError(
        f"{backend} has no structural plasticity (projection '{projection}'): its synapses neither form nor "
        "vanish while it runs; 'spinnaker' has it"
    )


def no_neuromodulation(backend: str, projection: str) -> CapabilityError:
    """Return the error for a brain backend whose STDP does not support rewards."""
    return CapabilityError(
        f"{backend} has no rewards and punishments (projection '{projection}'): STDP changes weights there "
        "without them; 'event', 'nest' and 'spinnaker' have them"
    )


def no_rewards(projection: str) -> CapabilityError:
    """Return the error for a brain backend in which only spikes reward."""
    return CapabilityError(
        f"projection '{projection}': on this brain backend only spikes reward; drive a population that sends "
        "its spikes to 'reward', or run on 'event'"
    )


def _no_type(backend: str, things: str, kind: str, valid: Iterable[str]) -> CapabilityError:
    return CapabilityError(f"{backend} has no {things}; {nearest(kind, valid)}")


def no_variable(
    population: str, variable: str, valid: Iterable[str] = (), *, source: bool = False
) -> CapabilityError:
    """Return the error for a state variable that the cells of a population do not have.

    Args:
        population: its label.
        variable: the variable.
        valid: the variables that they have, as far as known.
        source: whether they are spike sources, which have no state.
    """
    known = list(valid)
    hint = ", they only emit spikes" if source else did_you_mean(variable, known) if known else ""
    return CapabilityError(f"the cells of population '{population}' have no '{variable}'{hint}")


def not_shown(brain: object, variable: str, valid: Iterable[str]) -> CapabilityError:
    """Return the error for a state variable that a brain does not show of any cell."""
    return refusal(brain, f"does not show '{variable}'; it shows: {_join_names(valid, 'none')}")


def no_change(brain: object, thing: str, valid: Iterable[str]) -> CapabilityError:
    """Return the error for a change of the network that a brain cannot make while it runs."""
    return refusal(
        brain, f"cannot change {thing} while it runs; it can change: {_join_names(valid, 'nothing')}"
    )


def _join_names(names: Iterable[str], empty: str) -> str:
    return ", ".join(sorted(names)) or empty


# -- worlds


def world_lacks(backend: str, need: str) -> str:
    """Return the clause about a capability that a world backend does not have."""
    return f"the world backend '{backend}' lacks the capability '{need}'"


def immovable(model: str) -> str:
    """Return the clause about a model that only forces could move, for a world without dynamics."""
    return f"has no dynamics: '{model}' would not move; make it static"


def no_joint(model: str, joint: str, need: str) -> str:
    """Return the clause about a joint that needs a capability, such as ``ball_joints``."""
    return f"has no {need.replace('_', ' ')}, such as '{model}/{joint}'"


def no_drive(model: str, drive: str, need: str) -> str:
    """Return the clause about a drive, such as a muscle, that needs a capability."""
    which = {
        "wrapping": "which wraps around shapes or joints",
        "own_actuators": "which, or whose tendon or joint, has limits or forces that only MuJoCo has",
    }
    if need in which:
        return f"cannot simulate the muscle '{drive}' of '{model}', {which[need]}"
    return f"has no {need.replace('_', ' ')}, such as '{drive}' of '{model}'"
