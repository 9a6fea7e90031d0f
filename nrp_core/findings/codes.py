"""Every kind of finding about an experiment, with what ``nrp explain`` says of it.

A code never changes its meaning, so that people can look it up and scripts can rely on it.
``docs/reference/findings.md`` is generated from this table.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum


@dataclass(frozen=True, slots=True)
class Explanation:
    """What a code stands for.

    Args:
        summary: what is wrong, one sentence.
        why: what comes of it.
        suggestion: what to do about it.
    """

    summary: str
    why: str
    suggestion: str


_E = Explanation


class Code(Enum):
    """A kind of finding; its value explains it."""

    # -- the experiment file
    NRP200 = _E(
        "The file is not YAML, or not text.",
        "Nothing of it can be read, so nothing else is checked.",
        "Correct the line named: mostly an indentation, a bracket, or a colon without a space behind it.",
    )
    NRP201 = _E(
        "A key that the format does not have.",
        "It would be ignored, and what it was to set would keep its default.",
        "Take the key that is proposed, or see `nrp schema experiment` for all of them.",
    )
    NRP202 = _E(
        "A value of the wrong kind, or out of range.",
        "The run would differ from what you intended.",
        "Write a value of the kind that the message names, within its limits.",
    )
    NRP203 = _E(
        "A key that is needed is missing.",
        "There is no default that would be right for every experiment.",
        "Add the key; `nrp schema experiment` shows what goes into it.",
    )
    NRP204 = _E(
        "A file that does not exist.",
        "What the file holds is needed to build the experiment.",
        "Correct its name; relative names start at the folder of the file that names it.",
    )
    NRP205 = _E(
        "A backend that is not installed or does not load.",
        "Without it one side of the loop has no simulator.",
        "Choose one that `nrp backends` lists, or install the one that is missing.",
    )
    NRP206 = _E(
        "A backend option that is unknown or wrong.",
        "Each backend has options of its own; this one would not take effect.",
        "Take an option that the message names; `nrp schema` shows those of a backend.",
    )
    NRP207 = _E(
        "Time steps that do not divide each other.",
        "Brain and world meet at the end of every loop step and have to be there exactly.",
        "Choose a loop period that is a multiple of the steps of both sides.",
    )
    NRP208 = _E(
        "The brain file cannot be turned into a network.",
        "Without a network there are no neurons to simulate or to connect to.",
        "Correct what the message names. A script in PyNN also runs by itself, with its whole traceback.",
    )
    NRP209 = _E(
        "A robot or room cannot be read.",
        "A part that is not read is not simulated.",
        "Correct the line that the message names; a warning says what is used instead.",
    )
    NRP210 = _E(
        "A transfer function is written wrongly.",
        "It cannot be connected to brain and robot.",
        "Write it as docs/reference/transfer-functions.md shows.",
    )
    NRP211 = _E(
        "Neurons that the network does not have.",
        "A device on them would have nothing to read or drive.",
        "Compare the name and index with `populations` in the experiment and with the brain script.",
    )
    NRP212 = _E(
        "A topic that does not exist, or has another type or direction.",
        "Nothing would ever come, or nobody would hear what is sent.",
        "Take the name and the type that the message gives; a sensor is subscribed to, a drive is "
        "published on.",
    )
    NRP213 = _E(
        "An event or criterion refers to something that does not exist.",
        "It could never happen, or never be decided.",
        "Take one of the names that the message lists.",
    )
    NRP214 = _E(
        "The experiment that this one extends cannot be read.",
        "What this one inherits is missing.",
        "Correct the name under `extends`; no experiment may extend itself.",
    )
    NRP215 = _E(
        "An override that cannot be applied.",
        "The run would not be the one that was asked for.",
        "Write `dotted.key=value`, with a key of the experiment and a value as in YAML.",
    )
    NRP216 = _E(
        "The backend does not have what the experiment asks.",
        "It would refuse the experiment when it is opened.",
        "Choose a backend that has it (`nrp backends`), or a model that this one has.",
    )

    NRP217 = _E(
        "Something of the network that the brain backend would not keep.",
        "The network runs, but not quite as the script says.",
        "Choose another backend or model where that matters.",
    )

    # -- names
    NRP218 = _E(
        "An import that finds nothing.",
        "The file cannot be loaded; one of the Neurorobotics Platform is loaded all the same, and fails "
        "where it uses what is missing.",
        "Correct the name, put the module beside the file, or install its package.",
    )
    NRP219 = _E(
        "A parameter and its mapping do not meet.",
        "Each parameter but `t` is what one mapping makes of it; without one it has no value.",
        "Let each parameter and the first argument of one mapping have the same name.",
    )
    NRP220 = _E(
        "A parameter that is mapped and never used.",
        "It costs time and often shows that another name was meant in the body.",
        "Use it, or remove the parameter and its mapping.",
    )
    NRP221 = _E(
        "The first parameter is not the time, `t`.",
        "The loop passes the time first, so all other parameters would be shifted.",
        "Begin the parameters with `t`, even if the body does not use it.",
    )

    # -- devices
    NRP222 = _E(
        "A device of the other direction.",
        "MapSpikeSink reads neurons and MapSpikeSource drives them; a device does one of both.",
        "Change the mapping or the kind of device.",
    )
    NRP223 = _E(
        "A device, topic or variable does not have this attribute.",
        "The function raises AttributeError when it comes to that line.",
        "Take an attribute that it has: `rate` of a Poisson source, `voltage` of a leaky integrator, "
        "`value` of a topic or variable.",
    )
    NRP224 = _E(
        "Something is set that can only be read.",
        "Sinks and subscribed topics show what is so; setting them changes nothing.",
        "Set a source, publish on a topic, or keep the value in a variable.",
    )
    NRP225 = _E(
        "A setting of a device that does not exist or is out of range.",
        "The device refuses it: rates and deviations are not negative, and everything is a finite number.",
        "Take a setting and a value that the message allows.",
    )

    # -- messages
    NRP226 = _E(
        "A message has no such field.",
        "The function raises AttributeError when it comes to that line.",
        "Take a field of the message type; the message lists them.",
    )
    NRP227 = _E(
        "The arguments of a message do not fit its fields.",
        "It could not be made, or its topic would refuse it.",
        "Give the fields in their order or by name, each of its own type.",
    )
    NRP228 = _E(
        "A message of another type than its topic carries.",
        "The topic refuses it when it is sent.",
        "Send a message of the topic's type, or correct the type of the topic.",
    )

    # -- how functions work together
    NRP229 = _E(
        "Two functions publish on one topic.",
        "In a step in which both run, the later one overwrites the earlier.",
        "Let one function send the sum, or let them publish on topics of their own.",
    )
    NRP230 = _E(
        "Two sources of one kind drive the same neurons.",
        "Their effects add up, which is seldom meant.",
        "Let one source drive them, or correct the indices.",
    )
    NRP231 = _E(
        "A source that is never set.",
        "It stays silent for the whole run.",
        "Set its rate or amplitude in the body, or in the mapping: `MapSpikeSource(..., nrp.poisson, "
        "rate=10.0)`.",
    )

    # -- numbers
    NRP232 = _E(
        "A division by zero.",
        "The function raises ZeroDivisionError when it comes to that line.",
        "Correct the divisor.",
    )
    NRP233 = _E(
        "A quantity of one unit is used as one of another.",
        "It can be right, if a factor carries the missing unit; then the factor deserves a name.",
        "Check the gain: `rate_hz = GAIN_HZ_PER_MV * sink.voltage`.",
    )

    # -- time
    NRP234 = _E(
        "A rate that the loop cannot give.",
        "A function runs at most once a step, so the limit has no effect.",
        "Lower the rate, or shorten the time step of the loop.",
    )

    # -- functions
    NRP235 = _E(
        "Two transfer functions of one name.",
        "The name says which one is meant in reports and recordings.",
        "Rename one of them.",
    )
    NRP236 = _E(
        "A name that cannot be used, or that hides another one.",
        "What it hides cannot be reached inside the function.",
        "Rename the parameter.",
    )
    NRP237 = _E(
        "What a function returns and where it goes do not fit.",
        "A value that no topic takes is lost, and a topic that gets no value stays silent.",
        "Return a message, or name a topic: `@nrp.Neuron2Robot(Topic(...))`.",
    )
    NRP238 = _E(
        "How long it takes from a sensor to an actuator.",
        "Each pass through the brain, and each step of the loop, adds a delay to the behaviour.",
        "A shorter time step of the loop shortens it.",
    )
    NRP239 = _E(
        "Something that is known only when it runs.",
        "Transfer functions are read and not executed by this check, so what this depends on is left out.",
        "Nothing has to be done; written plainly it could be checked.",
    )
    NRP240 = _E(
        "A call with arguments that the function does not take.",
        "The function raises TypeError when it comes to that line.",
        "Call it as the message shows.",
    )
    NRP241 = _E(
        "A module does not have this name.",
        "The function raises AttributeError when it comes to that line.",
        "Take the name that is proposed.",
    )
    NRP242 = _E(
        "A value that is computed and never used.",
        "Often another name was meant where it should be used.",
        "Use it or remove it.",
    )
    NRP243 = _E(
        "A function depends on the wall clock or on a global random generator.",
        "Two runs with one seed will differ; while a function sleeps, simulated time stands still.",
        "Use `t` for the time, and noise devices or a seeded generator in a variable for randomness.",
    )
    NRP244 = _E(
        "The brain script takes too long to be checked.",
        "What depends on the network, such as the range of indices, was not checked.",
        "Run the experiment; if the script never ends, look at its loops.",
    )
    NRP245 = _E(
        "A function is triggered by what gives no news.",
        "Only messages of a subscribed topic let a function run; it would never run, or cannot be bound.",
        "Name parameters that MapRobotSubscriber maps, or leave `triggers` out.",
    )
    NRP246 = _E(
        "A name that nothing defines.",
        "The function raises NameError when it comes to that line.",
        "Correct the spelling, import the module, or add the parameter and its mapping.",
    )
    NRP247 = _E(
        "A device, a topic or a message where a number is meant.",
        "The function raises TypeError when it comes to that line.",
        "Take what it tells: `camera.value`, `wheel.voltage`, `message.data`.",
    )
    NRP248 = _E(
        "Something that never happens.",
        "The run is over before, or one event waits for another that waits for it.",
        "Times of an experiment file carry their unit; `t` is in seconds from the start of the run.",
    )
    NRP249 = _E(
        "An angle without a unit that is more than a whole turn.",
        "Numbers without a unit are radians; 180 of them are nearly 29 turns.",
        "Write the unit: `180 deg`.",
    )
    NRP250 = _E(
        "Two sinks of a function that always tell the same.",
        "Often one of them was meant for other neurons, such as those of the other wheel.",
        "Correct the indices, or use one sink in both places.",
    )
    NRP251 = _E(
        "A loop without a way out.",
        "The function never returns, and the run waits for it until its time limit ends it.",
        "Leave the loop with `break` or `return`; what takes time goes over many steps.",
    )
    NRP252 = _E(
        "An item is taken of what has none, or not so many.",
        "The function raises TypeError or IndexError when it comes to that line.",
        "A number, a message and a single device have no items; those of a device group begin at 0.",
    )
    NRP253 = _E(
        "A parameter is given another value, and then used as if it were still what it stood for.",
        "Assigning to the name changes neither a variable nor a device; the name is only something else.",
        "Set what it has: `kept.value = ...`, `eye.rate = ...`, or take another name.",
    )
    NRP254 = _E(
        "A row that does not fit the headers of its file.",
        "Cells stand below headers that are not theirs.",
        "Record one value for each header; headers are a list of texts.",
    )
    NRP255 = _E(
        "Something of an experiment of the Neurorobotics Platform is converted, replaced or left out.",
        "The rest runs; what the message names may not do quite what it did there.",
        "Nothing, unless it matters: docs/reference/nrp-experiments.md shows what becomes of what.",
    )

    @property
    def summary(self) -> str:
        """What is wrong, one sentence."""
        return self.value.summary

    @property
    def why(self) -> str:
        """What comes of it."""
        return self.value.why

    @property
    def suggestion(self) -> str:
        """What to do about it."""
        return self.value.suggestion
