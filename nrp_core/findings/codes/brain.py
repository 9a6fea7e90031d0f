"""Findings about the brain: its file or script, its network, its backend."""

from nrp_core.findings.codes.explanation import Explanation, Weight

SCRIPT_FAILED = Explanation(
    "A brain script or file that does not give a network: it fails, is invalid, or takes too long.",
    "Without a network there are no neurons to simulate or connect.",
    "Correct the line or value in the message; `nrp run --debug` adds the whole traceback, and "
    "`brain.time_limit` sets the time of a script.",
    "{n} brain scripts or files do not give a network",
    Weight.ALTERED,
)

NO_SUCH_NEURONS = Explanation(
    "Neurons that the network does not have.",
    "A device on these neurons would have no effect.",
    "Compare the name and index with `populations` in the experiment and with the brain script.",
    "{n} references to neurons that do not exist",
    Weight.ALTERED,
)

BRAIN_LEFT_OUT = Explanation(
    "The brain is left out.",
    "The experiment runs without neurons: all spike counts are zero.",
    "Correct the cause that the message names: a missing file, or a file that cannot be read.",
    "{n} brains are left out",
    Weight.INCOMPLETE,
)

IMPLAUSIBLE = Explanation(
    "A value of the network is probably in another unit, or a population fires as often as no neuron does.",
    "The network is simulated unchanged. PyNN's units are ms, mV, nF, nA, uS and Hz.",
    "Compare the value with the unit in the message; no action is needed if it is intended.",
    "{n} values of the network are probably in another unit",
    Weight.REMARK,
)

UNLIKE_SCRIPT = Explanation(
    "A part of a brain script contradicts another part, or has no effect.",
    "The network runs, but a label, current or limit differs from the script.",
    "Give each population and projection a unique label, inject each current source, and correct delays.",
    "{n} parts of brain scripts contradict others or have no effect",
    Weight.REMARK,
)

UNREACHABLE_THRESHOLD = Explanation(
    "The inputs of a population cannot make a cell fire: there are none, or they are too weak.",
    "The cells never fire, so their targets and devices do not receive spikes.",
    "Connect the population, increase the weights (nA for cells with currents, uS with conductances), or "
    "lower the threshold.",
    "{n} populations cannot fire with the weights of their inputs",
    Weight.ALTERED,
)
