"""Every kind of finding about an experiment, with the explanation that ``nrp explain`` prints.

A code never changes its meaning, so that people can look it up and scripts can rely on it.
``docs/reference/findings.md`` is generated from this table.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum


@dataclass(frozen=True, slots=True)
class Explanation:
    """The explanation of a code.

    Args:
        summary: what is wrong, one sentence.
        why: the consequence.
        suggestion: how to fix it.
    """

    summary: str
    why: str
    suggestion: str


_E = Explanation


class Code(Enum):
    """A kind of finding; its value explains it."""

    # -- the experiment file
    NRP200 = _E(
        "The file is not valid YAML, or not text.",
        "The file cannot be read, so nothing else is checked.",
        "Correct the reported line: check indentation, brackets, and the space after each colon.",
    )
    NRP201 = _E(
        "A key that the format does not have.",
        "The key would be ignored, and the intended setting would keep its default.",
        "Use the suggested key; `nrp schema experiment` lists all keys.",
    )
    NRP202 = _E(
        "A value of the wrong kind, or out of range.",
        "The run would differ from what you intended.",
        "Write a value of the kind that the message names, within its limits.",
    )
    NRP203 = _E(
        "A required key is missing.",
        "No default suits every experiment.",
        "Add the key; `nrp schema experiment` shows its format.",
    )
    NRP204 = _E(
        "A file that does not exist.",
        "The experiment cannot be built without the file.",
        "Correct the path; relative paths start at the folder of the file that contains them.",
    )
    NRP205 = _E(
        "A backend that is not installed or does not load.",
        "Without it one side of the loop has no simulator.",
        "Choose a backend that `nrp backends` lists, or install the missing one.",
    )
    NRP206 = _E(
        "A backend option that is unknown or wrong.",
        "Each backend has its own options; this one would have no effect.",
        "Use one of the options in the message.",
    )
    NRP207 = _E(
        "Time steps that do not divide each other.",
        "Brain and world synchronize at the end of every loop step, so both must reach that time exactly.",
        "Choose a loop period that is a multiple of the time steps of both sides.",
    )
    NRP208 = _E(
        "The brain file cannot be turned into a network.",
        "Without a network there are no neurons to simulate or connect.",
        "Correct what the message names. A script in PyNN also runs by itself, with its whole traceback.",
    )
    NRP209 = _E(
        "A robot or room cannot be read.",
        "A part that is not read is not simulated.",
        "Correct the line that the message names; a warning says what is used instead.",
    )
    NRP210 = _E(
        "A transfer function is declared incorrectly.",
        "The function cannot be connected to brain and robot.",
        "Declare it as docs/reference/transfer-functions.md shows.",
    )
    NRP211 = _E(
        "Neurons that the network does not have.",
        "A device on these neurons would have nothing to read or drive.",
        "Compare the name and index with `populations` in the experiment and with the brain script.",
    )
    NRP212 = _E(
        "A topic that does not exist, or has another type or direction.",
        "No message would arrive, or nothing would receive the published messages.",
        "Use the name and type in the message; subscribe to sensors, publish on the topics of drives.",
    )
    NRP213 = _E(
        "An event or criterion refers to something that does not exist.",
        "The event could never happen, or the criterion could never be decided.",
        "Use one of the names in the message.",
    )
    NRP214 = _E(
        "The experiment that this one extends cannot be read.",
        "The inherited settings are missing.",
        "Correct the name under `extends`; an experiment cannot extend itself.",
    )
    NRP215 = _E(
        "An override that cannot be applied.",
        "The run would differ from the one that you requested.",
        "Write `dotted.key=value`, with a key of the experiment and a value in YAML.",
    )
    NRP216 = _E(
        "The backend lacks a capability that the experiment needs.",
        "The backend would refuse the experiment when it is opened.",
        "Choose a backend with this capability (`nrp backends`), or a model that this backend supports.",
    )

    NRP217 = _E(
        "A property of the network that the brain backend changes.",
        "The network runs, but differs from the script.",
        "Choose another backend or model if the property matters.",
    )

    # -- names
    NRP218 = _E(
        "An imported module or name does not exist.",
        "The file cannot be loaded; a file of the Neurorobotics Platform is loaded anyway and fails "
        "where it uses the missing name.",
        "Correct the name, put the module next to the file, or install its package.",
    )
    NRP219 = _E(
        "A parameter and its mapping do not match.",
        "Each parameter except `t` gets its value from one mapping; without a mapping it has none.",
        "Give each parameter the name in the first argument of one mapping.",
    )
    NRP220 = _E(
        "A parameter is mapped but never used.",
        "The mapping costs time, and often another name in the body was intended.",
        "Use the parameter, or remove it and its mapping.",
    )
    NRP221 = _E(
        "The first parameter is not the time, `t`.",
        "The loop passes the time first, so all other parameters would be shifted.",
        "Make `t` the first parameter, even if the body does not use it.",
    )

    # -- devices
    NRP222 = _E(
        "A device is used in the wrong direction.",
        "MapSpikeSink reads neurons and MapSpikeSource drives them; a device does only one of these.",
        "Change the mapping or the kind of device.",
    )
    NRP223 = _E(
        "A device, topic or variable does not have this attribute.",
        "The function raises AttributeError at that line.",
        "Use an existing attribute: `rate` of a Poisson source, `voltage` of a leaky integrator, "
        "`value` of a topic or variable.",
    )
    NRP224 = _E(
        "A read-only attribute is set.",
        "Sinks and subscribed topics only report values; setting them has no effect.",
        "Set a source, publish on a topic, or keep the value in a variable.",
    )
    NRP225 = _E(
        "A setting of a device that does not exist or is out of range.",
        "The device refuses it: rates and deviations must not be negative, and all values must be finite.",
        "Use a setting and a value that the message allows.",
    )

    # -- messages
    NRP226 = _E(
        "A message does not have this field.",
        "The function raises AttributeError at that line.",
        "Use a field of the message type; the finding lists them.",
    )
    NRP227 = _E(
        "The arguments of a message do not fit its fields.",
        "The message could not be created, or its topic would refuse it.",
        "Give the fields in order or by name, each with the correct type.",
    )
    NRP228 = _E(
        "The type of a message differs from the type of its topic.",
        "The topic refuses the message when it is published.",
        "Publish a message of the topic's type, or correct the type of the topic.",
    )

    # -- how functions work together
    NRP229 = _E(
        "Two functions publish on one topic.",
        "In a step in which both run, the later one overwrites the earlier.",
        "Publish the sum from one function, or use a separate topic for each function.",
    )
    NRP230 = _E(
        "Two sources of the same kind drive the same neurons.",
        "Their effects add up, which is seldom intended.",
        "Use one source, or correct the indices.",
    )
    NRP231 = _E(
        "A source that is never set.",
        "The source stays silent for the whole run.",
        "Set its rate or amplitude in the body, or in the mapping: `MapSpikeSource(..., nrp.poisson, "
        "rate=10.0)`.",
    )

    # -- numbers
    NRP232 = _E(
        "A division by zero.",
        "The function raises ZeroDivisionError at that line.",
        "Correct the divisor.",
    )
    NRP233 = _E(
        "A quantity in one unit is used as a quantity in another unit.",
        "This is correct only if a factor carries the missing unit; such a factor should have a name.",
        "Check the gain: `rate_hz = GAIN_HZ_PER_MV * sink.voltage`.",
    )

    # -- time
    NRP234 = _E(
        "A rate that is higher than the loop allows.",
        "A function runs at most once a step, so the limit has no effect.",
        "Lower the rate, or shorten the time step of the loop.",
    )

    # -- functions
    NRP235 = _E(
        "Two transfer functions have the same name.",
        "Reports and recordings identify a function by its name.",
        "Rename one of them.",
    )
    NRP236 = _E(
        "A name is not allowed, or hides another name.",
        "The hidden name cannot be used inside the function.",
        "Rename the parameter.",
    )
    NRP237 = _E(
        "The return value of a function does not match its topic.",
        "A value without a topic is lost, and a topic without a value stays silent.",
        "Return a message, or name a topic: `@nrp.Neuron2Robot(Topic(...))`.",
    )
    NRP238 = _E(
        "The delay from a sensor to an actuator.",
        "Each pass through the brain and each step of the loop delays the behaviour.",
        "Use a shorter time step of the loop to reduce the delay.",
    )
    NRP239 = _E(
        "A value is known only at run time.",
        "The check does not execute transfer functions, so it skips everything that depends on this value.",
        "No action is needed; a literal value would allow the check.",
    )
    NRP240 = _E(
        "A call has arguments that the function does not accept.",
        "The function raises TypeError at that line.",
        "Call it as the message shows.",
    )
    NRP241 = _E(
        "A module does not have this name.",
        "The function raises AttributeError at that line.",
        "Use the suggested name.",
    )
    NRP242 = _E(
        "A value is computed but never used.",
        "Often another name was used by mistake in its place.",
        "Use the value or remove it.",
    )
    NRP243 = _E(
        "A function depends on the wall clock or on a global random generator.",
        "Two runs with the same seed will differ; while a function sleeps, simulated time stands still.",
        "Use `t` for the time, and noise devices or a seeded generator in a variable for randomness.",
    )
    NRP244 = _E(
        "The brain script takes too long to be checked.",
        "Everything that depends on the network, such as the range of indices, was not checked.",
        "Run the experiment; if the script never ends, look at its loops.",
    )
    NRP245 = _E(
        "A trigger is not a parameter of a subscribed topic.",
        "Only subscribed topics trigger a function; this one would never run, or cannot be bound.",
        "Name parameters that MapRobotSubscriber maps, or omit `triggers`.",
    )
    NRP246 = _E(
        "An undefined name.",
        "The function raises NameError at that line.",
        "Correct the spelling, import the module, or add the parameter and its mapping.",
    )
    NRP247 = _E(
        "A device, a topic or a message is used as a number.",
        "The function raises TypeError at that line.",
        "Use its value: `camera.value`, `wheel.voltage`, `message.data`.",
    )
    NRP248 = _E(
        "An event or condition that can never happen.",
        "The run ends earlier, or two events wait for each other.",
        "Check the times: an experiment file needs units; `t` is in seconds from the start of the run.",
    )
    NRP249 = _E(
        "An angle without a unit exceeds a full turn.",
        "Numbers without a unit are radians; 180 of them are nearly 29 turns.",
        "Write the unit: `180 deg`.",
    )
    NRP250 = _E(
        "Two sinks of a function always have the same value.",
        "Often one of them was intended for other neurons, such as those of the other wheel.",
        "Correct the indices, or use one sink in both places.",
    )
    NRP251 = _E(
        "A loop without a way out.",
        "The function never returns, and the run waits until its time limit.",
        "Leave the loop with `break` or `return`; spread long work over many steps.",
    )
    NRP252 = _E(
        "An index is applied to an object without items, or is out of range.",
        "The function raises TypeError or IndexError at that line.",
        "Index only lists and device groups, from 0; a number, a message and a single device have no items.",
    )
    NRP253 = _E(
        "A parameter is reassigned and then used as if it still had its original value.",
        "The assignment changes neither the variable nor the device; it only rebinds the name.",
        "Set an attribute: `kept.value = ...`, `eye.rate = ...`, or use another name.",
    )
    NRP254 = _E(
        "A row does not match the headers of its file.",
        "Values appear in the wrong columns.",
        "Record one value for each header; headers are a list of texts.",
    )
    NRP255 = _E(
        "A part of an experiment of the Neurorobotics Platform is converted, replaced or omitted.",
        "The rest runs; the named part may behave differently than on that platform.",
        "No action is needed unless it matters; docs/reference/nrp-experiments.md lists the conversions.",
    )

    @property
    def summary(self) -> str:
        """What is wrong, one sentence."""
        return self.value.summary

    @property
    def why(self) -> str:
        """The consequence."""
        return self.value.why

    @property
    def suggestion(self) -> str:
        """How to fix it."""
        return self.value.suggestion
