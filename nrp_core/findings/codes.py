"""The kinds of findings, with the explanations that ``nrp explain`` prints.

A code never changes its meaning, so that people can look it up and scripts can rely on it; numbers of
``removed_codes.py`` are not used again. The message of a finding names its object, so the code that makes
the finding has it; :mod:`nrp_core.findings.refusals` has the words that several share.
``docs/reference/findings.md`` is generated from this table.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum, IntEnum, unique


class Weight(IntEnum):
    """The effect of a finding on a run, from the smallest to the largest; ordered."""

    REMARK = 1
    """The run is as requested; the finding is worth knowing."""
    ALTERED = 2
    """The run is complete, but something in it differs from the request."""
    INCOMPLETE = 3
    """Something that was requested is missing from the run, or the run ended early."""

    def __str__(self) -> str:
        return self.name.lower()


@dataclass(frozen=True, slots=True)
class Explanation:
    """The explanation of a code.

    Args:
        summary: the mistake, in one sentence.
        why: the consequence.
        suggestion: how to fix it.
        counted: the headline of several findings; ``{n}`` is their number.
        weight: the effect of a warning on a run; an error keeps the run from starting.
    """

    summary: str
    why: str
    suggestion: str
    counted: str
    weight: Weight


@unique
class Code(Enum):
    """A kind of finding; its value explains it."""

    NRP200 = Explanation(
        "The file, or the experiment that it extends, cannot be read.",
        "The file cannot be read, so nothing else is checked.",
        "Correct the name in the message, or the line: check its indentation, brackets, and the space after "
        "each colon.",
        "{n} files cannot be read",
        Weight.ALTERED,
    )
    NRP201 = Explanation(
        "An unknown key, or a missing one that the format requires.",
        "An unknown key would be ignored; a required key does not have a default value.",
        "Use the key or command that the message suggests; `nrp schema experiment` lists those of "
        "experiments.",
        "{n} unknown or missing keys",
        Weight.ALTERED,
    )
    NRP202 = Explanation(
        "A value, option, parameter, override or intervention of the wrong kind, out of range, or not "
        "declared.",
        "The run would differ from what you intended.",
        "Write a key and a value of the kind that the message names, within its limits; `nrp inspect "
        "EXPERIMENT` "
        "lists the parameters.",
        "{n} wrong values, options or parameters",
        Weight.ALTERED,
    )
    NRP204 = Explanation(
        "A file, module or package that does not exist.",
        "What uses it cannot be built, or does without it.",
        "Correct the path, which is relative to the folder of the file that contains it, or install the "
        "module.",
        "{n} files or modules do not exist",
        Weight.ALTERED,
    )
    NRP205 = Explanation(
        "A backend that is not installed or does not load.",
        "Without it one side of the loop has no simulator.",
        "Choose a backend that `nrp backends` lists, or install the missing one.",
        "{n} backends are not available",
        Weight.ALTERED,
    )
    NRP208 = Explanation(
        "A brain script or file that does not give a network: it fails, is invalid, or takes too long.",
        "Without a network there are no neurons to simulate or connect.",
        "Correct the line or value in the message; `nrp run --debug` adds the whole traceback, and "
        "`brain.time_limit` sets the time of a script.",
        "{n} brain scripts or files do not give a network",
        Weight.ALTERED,
    )
    NRP209 = Explanation(
        "A robot or room cannot be read, or does not fit into the world.",
        "The world cannot be built with it.",
        "Correct the file, line or name in the message.",
        "{n} robots or rooms cannot be read or do not fit",
        Weight.ALTERED,
    )
    NRP210 = Explanation(
        "A file of transfer functions cannot be loaded, or a declaration or trigger in it is wrong.",
        "The function is not connected to brain and robot as intended.",
        "Correct the line in the message; docs/reference/transfer-functions.md shows how functions are "
        "declared.",
        "{n} files or declarations of transfer functions are wrong",
        Weight.ALTERED,
    )
    NRP211 = Explanation(
        "Neurons that the network does not have.",
        "A device on these neurons would have no effect.",
        "Compare the name and index with `populations` in the experiment and with the brain script.",
        "{n} references to neurons that do not exist",
        Weight.ALTERED,
    )
    NRP212 = Explanation(
        "A topic that does not exist, has another type or direction, or has nothing at its other end.",
        "No message would arrive, or nothing would receive the published messages.",
        "Use a name and type that `nrp inspect` lists; subscribe to sensors, publish on the topics of "
        "drives.",
        "{n} uses of topics that do not fit the world",
        Weight.ALTERED,
    )
    NRP213 = Explanation(
        "An event or criterion refers to something that does not exist.",
        "The event could never happen, or the criterion could never be decided.",
        "Use one of the names in the message.",
        "{n} events or criteria refer to something that does not exist",
        Weight.ALTERED,
    )
    NRP216 = Explanation(
        "The backend, or nrp-core itself, does not support a part or setting of the experiment.",
        "The part that needs it has no effect; if the simulation needs it, the run does not start.",
        "Choose a backend with this capability (`nrp backends`), or remove the part that the message names.",
        "{n} parts or settings are not supported",
        Weight.ALTERED,
    )
    NRP217 = Explanation(
        "A property of the network that the reader of its file or the brain backend changes.",
        "The network runs, but differs from the script or file.",
        "Choose another backend or model if the property matters.",
        "{n} properties of the network are changed",
        Weight.ALTERED,
    )
    NRP229 = Explanation(
        "Two functions publish on one topic, or two sources drive the same neurons.",
        "The later message overwrites the earlier; the effects of sources add up.",
        "Write from one function, or correct the topic or the indices.",
        "{n} topics or neurons with several sources",
        Weight.REMARK,
    )
    NRP231 = Explanation(
        "A source that is never set.",
        "The source stays silent for the whole run.",
        "Set its rate or amplitude in the body, or in the mapping: `MapSpikeSource(..., nrp.poisson, "
        "rate=10.0)`.",
        "{n} sources are never set",
        Weight.REMARK,
    )
    NRP237 = Explanation(
        "The return value of a function does not match its topic.",
        "A value without a topic is lost, and a topic without a value does not publish messages.",
        "Return a message, or name a topic: `@nrp.Neuron2Robot(Topic(...))`.",
        "{n} return values do not match their topic",
        Weight.REMARK,
    )
    NRP238 = Explanation(
        "The delay from a sensor to an actuator.",
        "Each pass through the brain and each step of the loop delays the behaviour.",
        "Use a shorter time step of the loop to reduce the delay.",
        "{n} delays from a sensor to an actuator",
        Weight.REMARK,
    )
    NRP239 = Explanation(
        "Something was not checked.",
        "The check could not execute it, or it needs an engine, the network or more time; mistakes in it are "
        "not found.",
        "See the reason in the message; a run executes everything.",
        "{n} things were not checked",
        Weight.REMARK,
    )
    NRP240 = Explanation(
        "A transfer function raises an error.",
        "The run ends at that line, or goes on without the function; a topic or device may have refused a "
        "value.",
        "Correct the line; where the names, types or values that are possible are known, the message lists "
        "them.",
        "{n} transfer functions raise errors",
        Weight.ALTERED,
    )
    NRP246 = Explanation(
        "An undefined name.",
        "The function raises NameError at that line.",
        "Correct the spelling, import the module, or add the parameter and its mapping.",
        "{n} undefined names",
        Weight.ALTERED,
    )
    NRP248 = Explanation(
        "An event, condition or state that can never happen, or did not happen by the end of the run.",
        "Its messages are not published, and what waits for it does not happen either.",
        "Check the times: an experiment file needs units; `t` is in seconds from the start of the run.",
        "{n} events, conditions or states never happen",
        Weight.REMARK,
    )
    NRP249 = Explanation(
        "An angle without a unit exceeds a full turn.",
        "Numbers without a unit are radians; 180 rad are nearly 29 turns.",
        "Write the unit: `180 deg`.",
        "{n} angles without a unit exceed a full turn",
        Weight.REMARK,
    )
    NRP255 = Explanation(
        "A part of an experiment of the Neurorobotics Platform is converted, replaced or omitted.",
        "The rest runs; the named part may behave differently than on that platform.",
        "No action is needed unless it matters; docs/reference/nrp-experiments.md lists the conversions.",
        "{n} parts of the experiment are converted",
        Weight.REMARK,
    )
    NRP256 = Explanation(
        "A robot is left out, or the room, which is replaced by a plain floor.",
        "The experiment runs without it; whatever it should sense, do or contain is missing.",
        "Correct the cause that the message names: a missing file, or a file that cannot be read.",
        "{n} robots or rooms are left out",
        Weight.INCOMPLETE,
    )
    NRP258 = Explanation(
        "A mesh, texture, material or colour is missing or not supported, and is replaced.",
        "Cameras and rays see the replacement; bodies touch the simple shape that replaces a mesh.",
        "Put the file where the models are searched, or correct it.",
        "{n} meshes, textures or materials are replaced",
        Weight.ALTERED,
    )
    NRP260 = Explanation(
        "A part or plugin of a robot or room is left out, or exists only in another physics engine.",
        "It is not simulated; the rest of the model is.",
        "Correct the part as the message says, or remove it; docs/reference/scenes.md lists the plugins.",
        "{n} parts or plugins of models are left out",
        Weight.ALTERED,
    )
    NRP262 = Explanation(
        "A sensor, or a property of a sensor, is not simulated.",
        "The sensor does not publish messages, or publishes other messages than the file describes.",
        "Use a supported sensor (docs/reference/scenes.md), or functions that do not need it.",
        "{n} sensors are not simulated as described",
        Weight.ALTERED,
    )
    NRP264 = Explanation(
        "A value of a robot or room is impossible, or not supported, and another one is used.",
        "The model moves or looks as the message says.",
        "Write the intended value into the file.",
        "{n} values of models are replaced",
        Weight.ALTERED,
    )
    NRP265 = Explanation(
        "A joint or controller cannot be commanded as the file describes.",
        "Commands for it have no effect.",
        "Use a joint and a controller that the message or docs/reference/scenes.md allows.",
        "{n} joints or controllers cannot be commanded as described",
        Weight.ALTERED,
    )
    NRP266 = Explanation(
        "A part of a model or the frame of a sensor gets another name.",
        "Topics, services, messages and recordings use the new name.",
        "Give each part a name of its own, and a sensor the name of a link at its pose.",
        "{n} parts or frames of models are renamed",
        Weight.REMARK,
    )
    NRP269 = Explanation(
        "The brain is left out.",
        "The experiment runs without neurons: all spike counts are zero.",
        "Correct the cause that the message names: a missing file, or a file that cannot be read.",
        "{n} brains are left out",
        Weight.INCOMPLETE,
    )
    NRP272 = Explanation(
        "A transfer function or state machine is left out, or stopped by an error.",
        "The experiment runs without it.",
        "Correct the cause that the message names; with `strict: true` the experiment does not run without "
        "it.",
        "{n} transfer functions or state machines are left out or stopped",
        Weight.INCOMPLETE,
    )
    NRP276 = Explanation(
        "An error of an engine or of the experiment ended the run early.",
        "Everything after this time is missing.",
        "Correct the cause that the message names.",
        "{n} errors ended the run",
        Weight.INCOMPLETE,
    )
    NRP277 = Explanation(
        "A number of an engine or a variable became NaN, inaccurate, or exceeded its range.",
        "The results after this time may be wrong.",
        "Use a shorter time step or smaller values; in a function, test that there is something to compute "
        "with.",
        "{n} numerical problems",
        Weight.ALTERED,
    )
    NRP278 = Explanation(
        "A report of an engine that does not have a code of its own.",
        "The message describes the difference.",
        "Consult the documentation of the engine.",
        "{n} reports of engines",
        Weight.ALTERED,
    )
    NRP279 = Explanation(
        "An option, parameter or intervention has no effect, or a bad one, or the run went beyond its "
        "duration.",
        "The results do not change, or they are those of a longer run.",
        "Remove or change what the message names.",
        "{n} options, parameters or interventions have no useful effect",
        Weight.REMARK,
    )
    NRP280 = Explanation(
        "A request or goal was rejected, or a callback of the experiment raised an error.",
        "The requested change was not made, or the message or event had no effect.",
        "Correct the request or the callback as the message says.",
        "{n} requests were rejected or callbacks failed",
        Weight.ALTERED,
    )
    NRP282 = Explanation(
        "A message was dropped before its receiver read it, or cannot be carried from or to another program.",
        "The receiver does not get the message.",
        "Correct the type or the values, or let the function run more often, as the message says.",
        "{n} messages or topics were not carried",
        Weight.ALTERED,
    )
    NRP284 = Explanation(
        "A part of the run cannot be recorded.",
        "The run is unaffected; the recording lacks this part, and a replay may differ.",
        "No action is needed unless the part is needed later; the message names it.",
        "{n} parts of the run are not recorded",
        Weight.REMARK,
    )
    NRP285 = Explanation(
        "The replay does not have the same conditions as the recorded run.",
        "This may explain a difference from the recording.",
        "Replay with the version, machine and files of the recording if the difference matters.",
        "{n} conditions differ from the recorded run",
        Weight.REMARK,
    )
    NRP291 = Explanation(
        "A robot starts inside the room or another robot.",
        "The physics engine pushes the robot out, often so fast that it is thrown metres away.",
        "Move the start pose so that the robot does not overlap anything; usually z is too low.",
        "{n} robots start inside the room or another robot",
        Weight.ALTERED,
    )
    NRP292 = Explanation(
        "A robot or a loose model has nothing below it, or has fallen out of the room.",
        "The model falls. The drive of a falling robot has no effect; a floor falls with the objects on it.",
        "Add ground to the room, move the start pose above the ground, make fixed models `<static>`, or set "
        "the gravity of the room to 0.",
        "{n} models have no ground below them",
        Weight.ALTERED,
    )
    NRP294 = Explanation(
        "The run was interrupted or killed.",
        "Everything after this time is missing; criteria that were not decided by then remain open.",
        "Run the experiment again; `--until` ends a run early without an interruption.",
        "{n} interruptions",
        Weight.INCOMPLETE,
    )
    NRP297 = Explanation(
        "A value of the network is probably in another unit, or a population fires as often as no neuron "
        "does.",
        "The network is simulated unchanged. PyNN's units are ms, mV, nF, nA, uS and Hz.",
        "Compare the value with the unit in the message; no action is needed if it is intended.",
        "{n} values of the network are probably in another unit",
        Weight.REMARK,
    )
    NRP299 = Explanation(
        "A command, or a part of it, is beyond what its joint or drive can do.",
        "A joint goes to its limit instead; a drive ignores motions that it cannot perform.",
        "Scale the command to the limits that `nrp inspect` lists, use m/s and rad/s, or change the robot "
        "file.",
        "{n} topics get commands beyond what their joint or drive can do",
        Weight.REMARK,
    )
    NRP306 = Explanation(
        "A model starts high above everything below it, or lies below the ground.",
        "It falls and may be thrown over, or nothing above the ground sees or touches it.",
        "Correct z of its pose, which is in m from the origin of the room.",
        "{n} models start far above or below the ground",
        Weight.REMARK,
    )
    NRP308 = Explanation(
        "A part of a brain script contradicts another part, or has no effect.",
        "The network runs, but a label, current or limit differs from the script.",
        "Give each population and projection a unique label, inject each current source, and correct delays.",
        "{n} parts of brain scripts contradict others or have no effect",
        Weight.REMARK,
    )
    NRP357 = Explanation(
        "A transfer function waits.",
        "Simulated time advances only between calls, so the wait has no effect or never ends.",
        "Return, and act in a later call: compare `t` with a time stored in a variable.",
        "{n} transfer functions wait",
        Weight.ALTERED,
    )
    NRP370 = Explanation(
        "A robot with wheels starts tilted or upside down.",
        "The robot does not stand on its wheels, so its drive does not move it as commanded.",
        "Correct the angles of its start pose, which are in rad unless a unit is given: `90 deg`.",
        "{n} robots start tilted",
        Weight.ALTERED,
    )
    NRP371 = Explanation(
        "Lengths of a model are probably in another unit than metres.",
        "The model is 100 or 1000 times as large or small as intended.",
        "Give a mesh the scale 0.001 if it is in mm, or write lengths in m.",
        "{n} lengths are probably in another unit",
        Weight.REMARK,
    )
    NRP372 = Explanation(
        "A time step is probably in another unit, does not suit the loop, or does not divide that of the "
        "loop.",
        "The run is slow or inaccurate, or the robot reacts late; both sides must reach the end of each loop "
        "step exactly.",
        "Write steps with their unit; 20 ms is usual for the loop, and 1 to 5 ms for physics. Choose a "
        "loop step "
        "that is a multiple of the time steps of both sides.",
        "{n} time steps do not suit",
        Weight.REMARK,
    )
    NRP374 = Explanation(
        "A scanner or camera sees only its own robot.",
        "Its messages do not depend on the room.",
        "Move the sensor out of the shape that the message names, or turn it.",
        "{n} sensors see only their own robot",
        Weight.ALTERED,
    )
    NRP375 = Explanation(
        "Wheels of a drive do not touch the ground.",
        "The wheels turn, and the robot does not move as commanded.",
        "Give each wheel a collision shape that reaches lower than the rest of the robot.",
        "{n} drives have wheels without contact",
        Weight.ALTERED,
    )
    NRP376 = Explanation(
        "Two controllers, drives or plugins command one joint.",
        "They work against each other, or the last command counts.",
        "Remove one of them, name another joint, or on Gazebo leave the drive to it by `drive: plugin`.",
        "{n} joints have two controllers",
        Weight.ALTERED,
    )
    NRP377 = Explanation(
        "The inputs of a population cannot make a cell fire: there are none, or they are too weak.",
        "The cells never fire, so their targets and devices do not receive spikes.",
        "Connect the population, increase the weights (nA for cells with currents, uS with conductances), or "
        "lower the threshold.",
        "{n} populations cannot fire with the weights of their inputs",
        Weight.ALTERED,
    )
    NRP381 = Explanation(
        "A pose in a model is probably in another unit.",
        "The part is far from where it should be, or turned.",
        'Write positions in m and angles in rad; SDF has `<pose degrees="true">`.',
        "{n} poses are probably in another unit",
        Weight.REMARK,
    )
    NRP382 = Explanation(
        "A robot of an experiment of the Neurorobotics Platform fell, flew away, or was thrown at the start.",
        "Whatever it was to do after this time is missing from the run.",
        "Correct the start pose, put missing meshes where the models are searched, or hold the joints that "
        "bear "
        "the robot.",
        "{n} robots fell, flew away or were thrown",
        Weight.INCOMPLETE,
    )

    NRP383 = Explanation(
        "An element, attribute or parameter of a robot or room has no effect.",
        "The simulation ignores it: it is misspelled, misplaced, contradicted by another, or not supported.",
        "Correct its name or place, or remove it; docs/reference/scenes.md lists what is supported.",
        "{n} elements or parameters of models have no effect",
        Weight.ALTERED,
    )
    NRP384 = Explanation(
        "A mass, inertia, friction, limit, rate or colour in a model is missing or unusual.",
        "The message names the value that is used.",
        "No action is needed; write the value into the file if you know it.",
        "{n} values of models are completed",
        Weight.REMARK,
    )
    NRP385 = Explanation(
        "A learning rule, recorder, device or cell model of a brain file is not supported and does nothing.",
        "Synapses do not learn, a recorder stays empty, or nodes are silent: what rests on them is missing.",
        "Use a supported model, which the message or docs/reference/models.md names, or take the part out.",
        "{n} parts of the brain do nothing",
        Weight.INCOMPLETE,
    )
    NRP386 = Explanation(
        "An object that a robot holds or carries slides, although friction should hold it.",
        "MuJoCo's friction yields under a constant load: the object leaves the grasp after a while.",
        "Set the option `impratio` of the world to 100.",
        "{n} held objects slide",
        Weight.ALTERED,
    )

    def __repr__(self) -> str:
        return f"Code.{self.name}"

    @property
    def summary(self) -> str:
        """The mistake, in one sentence."""
        return self.value.summary

    @property
    def why(self) -> str:
        """The consequence."""
        return self.value.why

    @property
    def suggestion(self) -> str:
        """How to fix it."""
        return self.value.suggestion

    @property
    def weight(self) -> Weight:
        """The effect of a warning of this code on a run."""
        return self.value.weight

    def counted(self, n: int) -> str:
        """Return the headline of ``n`` findings of this code, n > 1."""
        return self.value.counted.format(n=n)
