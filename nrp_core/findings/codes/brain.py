"""Findings about the brain: its file or script, its network, its backend."""

from nrp_core.findings.codes.explanation import Explanation, Weight

SCRIPT_FAILED = Explanation(
    "A brain script that ends with an error, or builds a network that cannot be.",
    "Without a network there are no neurons to simulate or connect.",
    "Correct the line or value in the message; `nrp run --debug` adds the whole traceback.",
    "{n} brain scripts end with an error",
    Weight.ALTERED,
)

NO_NETWORK_IN_FILE = Explanation(
    "A file that is not a script and cannot be read as a network.",
    "Without a network there are no neurons to simulate or connect.",
    "Name a whole file in a format that an installed reader knows (docs/howto/keep-a-network.md), or write "
    "it again with the program that made it.",
    "{n} files cannot be read as networks",
    Weight.ALTERED,
)

ENDLESS_SCRIPT = Explanation(
    "The brain script takes longer than `brain.time_limit`.",
    "The script was stopped, so there is no network.",
    "If it should have ended, look at its loops from the line in the message on; if it needs the time, raise "
    "`brain.time_limit` or set it to `off`.",
    "{n} brain scripts take longer than their limit",
    Weight.ALTERED,
)

REFUSED_NETWORK = Explanation(
    "A network that the brain backend refuses.",
    "The network is a valid one, but this backend cannot simulate the value or part in the message.",
    "Change that value or part, or choose another brain backend (`nrp backends`).",
    "{n} networks are refused by the brain backend",
    Weight.ALTERED,
)

NO_SUCH_NEURONS = Explanation(
    "Neurons that the network does not have.",
    "A device on these neurons would have nothing to read or drive.",
    "Compare the name and index with `populations` in the experiment and with the brain script.",
    "{n} references to neurons that do not exist",
    Weight.ALTERED,
)

SLOW_SCRIPT = Explanation(
    "The brain script takes too long to be checked.",
    "Everything that depends on the network, such as the range of indices, was not checked.",
    "Run the experiment; if the script never ends, look at its loops.",
    "{n} brain scripts take too long to be checked",
    Weight.REMARK,
)

BRAIN_LEFT_OUT = Explanation(
    "The brain is left out.",
    "The experiment runs without neurons: all spike counts are zero.",
    "Correct the cause that the message names: a missing file, or a file that cannot be read.",
    "{n} brains are left out",
    Weight.INCOMPLETE,
)

BRAIN_FILE_CHANGED = Explanation(
    "A model, setting or statement of a brain file is ignored or replaced.",
    "The network runs, but differs from the brain file.",
    "No action is needed unless it matters; use a supported model or setting to avoid it.",
    "{n} models, settings or statements of brain files are ignored or replaced",
    Weight.ALTERED,
)

EMPTY_POPULATION = Explanation(
    "A population of the experiment has no neurons in the brain file.",
    "Devices on this population read and drive nothing.",
    "Correct the name, or the neurons that the experiment lists for it.",
    "{n} populations have no neurons",
    Weight.ALTERED,
)

UNCONNECTED = Explanation(
    "A population without a connection: to anything, from what excites it, or to what functions read.",
    "Its neurons do not affect the robot: their spikes lead nowhere, or they never fire.",
    "Connect it, or remove it; often a projection or a device names another population by mistake.",
    "{n} populations are connected to nothing, or never fire",
    Weight.REMARK,
)

TOO_FAST = Explanation(
    "A population fires as often as no neuron does.",
    "The run is as written, but a weight, a current or a time constant is probably in another unit.",
    "Compare the parameters of its cells and the weights onto them with the units of the cell model.",
    "{n} populations fire as often as no neuron does",
    Weight.REMARK,
)

IMPLAUSIBLE = Explanation(
    "A value of the network is probably in another unit.",
    "The network runs as written. PyNN's units are ms, mV, nF, nA, uS and Hz.",
    "Compare the value with the unit in the message; no action is needed if it is intended.",
    "{n} values of the network are probably in another unit",
    Weight.REMARK,
)

UNLIKE_SCRIPT = Explanation(
    "A part of a brain script contradicts another part, or has no effect.",
    "The network runs, but some label, current or limit is not the one in the script.",
    "Give each population and projection a label of its own, inject each current source, and correct delays.",
    "{n} parts of brain scripts contradict others or have no effect",
    Weight.REMARK,
)

IMPOSSIBLE_VARIANT = Explanation(
    "An intervention in the brain, or a control of its wiring, cannot be applied.",
    "The run would show the unchanged brain.",
    "Use one of the names in the message, or leave out the intervention or control.",
    "{n} interventions or controls cannot be applied",
    Weight.ALTERED,
)

IDLE_INTERVENTION = Explanation(
    "An intervention affects no synapse.",
    "It has no effect: the run is that of the brain without it.",
    "Name cells that have synapses, and both ends in the right order.",
    "{n} interventions have no effect",
    Weight.REMARK,
)

UNREACHABLE_THRESHOLD = Explanation(
    "Synapses or a device are too weak to make a cell fire.",
    "The cells never fire, so whatever reads their spikes gets none.",
    "Weights are in nA for cells with currents, in uS for cells with conductances; or lower the threshold.",
    "{n} populations cannot fire with the weights of their inputs",
    Weight.ALTERED,
)
