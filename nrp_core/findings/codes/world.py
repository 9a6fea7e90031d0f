"""Findings about robots, rooms and topics."""

from nrp_core.findings.codes.explanation import Explanation, Weight

NOT_READABLE = Explanation(
    "A robot or room cannot be read, or does not fit into the world.",
    "The world cannot be built with it.",
    "Correct the file, line or name in the message.",
    "{n} robots or rooms cannot be read or do not fit",
    Weight.ALTERED,
)

WRONG_TOPIC = Explanation(
    "A topic that does not exist, has another type or direction, or has nothing at its other end.",
    "No message would arrive, or nothing would receive the published messages.",
    "Use a name and type that `nrp inspect` lists; subscribe to sensors, publish on the topics of drives.",
    "{n} uses of topics that do not fit the world",
    Weight.ALTERED,
)

ROBOT_LEFT_OUT = Explanation(
    "A robot is left out, or the room, which is replaced by a plain floor.",
    "The experiment runs without it; whatever it should sense, do or contain is missing.",
    "Correct the cause that the message names: a missing file, or a file that cannot be read.",
    "{n} robots or rooms are left out",
    Weight.INCOMPLETE,
)

MESH_REPLACED = Explanation(
    "A mesh, texture, material or colour is missing or not supported, and is replaced.",
    "Cameras and rays see the replacement; bodies touch the simple shape that replaces a mesh.",
    "Put the file where the models are searched, or correct it.",
    "{n} meshes, textures or materials are replaced",
    Weight.ALTERED,
)

PART_LEFT_OUT = Explanation(
    "A part or plugin of a robot or room is left out, or exists only in another physics engine.",
    "It is not simulated; the rest of the model is.",
    "Correct the part as the message says, or remove it; docs/reference/scenes.md lists the plugins.",
    "{n} parts or plugins of models are left out",
    Weight.ALTERED,
)

SENSOR_NOT_SIMULATED = Explanation(
    "A sensor, or a property of a sensor, is not simulated.",
    "The sensor does not publish messages, or publishes other messages than the file describes.",
    "Use a supported sensor (docs/reference/scenes.md), or functions that do not need it.",
    "{n} sensors are not simulated as described",
    Weight.ALTERED,
)

VALUE_REPLACED = Explanation(
    "A value of a robot or room is ignored, missing or impossible.",
    "The model moves or looks as the message says.",
    "Write the intended value into the file; correct the name of an element if it is misspelled.",
    "{n} values of models are ignored or replaced",
    Weight.ALTERED,
)

NOT_CONTROLLED = Explanation(
    "A joint or controller cannot be commanded as the file describes.",
    "Commands for it have no effect.",
    "Use a joint and a controller that the message or docs/reference/scenes.md allows.",
    "{n} joints or controllers cannot be commanded as described",
    Weight.ALTERED,
)

RENAMED = Explanation(
    "A part of a model or the frame of a sensor gets another name.",
    "Topics, services, messages and recordings use the new name.",
    "Give each part a name of its own, and a sensor the name of a link at its pose.",
    "{n} parts or frames of models are renamed",
    Weight.REMARK,
)

STARTS_INSIDE = Explanation(
    "A robot starts inside the room or another robot.",
    "The physics engine pushes the robot out, often so fast that it is thrown metres away.",
    "Move the start pose so that the robot does not overlap anything; usually z is too low.",
    "{n} robots start inside the room or another robot",
    Weight.ALTERED,
)

NO_GROUND = Explanation(
    "A robot or a loose model has nothing below it, or has fallen out of the room.",
    "The model falls. The drive of a falling robot has no effect; a floor falls with the objects on it.",
    "Add ground to the room, move the start pose above the ground, make fixed models `<static>`, or set "
    "the gravity of the room to 0.",
    "{n} models have no ground below them",
    Weight.ALTERED,
)

BEYOND_LIMIT = Explanation(
    "A command, or a part of it, is beyond what its joint or drive can do.",
    "A joint goes to its limit instead; a drive ignores motions that it cannot perform.",
    "Scale the command to the limits that `nrp inspect` lists, use m/s and rad/s, or change the robot file.",
    "{n} topics get commands beyond what their joint or drive can do",
    Weight.REMARK,
)

STARTS_HIGH = Explanation(
    "A model starts high above everything below it, or lies below the ground.",
    "It falls and may be thrown over, or nothing above the ground sees or touches it.",
    "Correct z of its pose, which is in m from the origin of the room.",
    "{n} models start far above or below the ground",
    Weight.REMARK,
)

TILTED_START = Explanation(
    "A robot with wheels starts tilted or upside down.",
    "The robot does not stand on its wheels, so its drive does not move it as commanded.",
    "Correct the angles of its start pose, which are in rad unless a unit is given: `90 deg`.",
    "{n} robots start tilted",
    Weight.ALTERED,
)

LENGTH_UNIT = Explanation(
    "Lengths of a model are probably in another unit than metres.",
    "The model is 100 or 1000 times as large or small as intended.",
    "Give a mesh the scale 0.001 if it is in mm, or write lengths in m.",
    "{n} lengths are probably in another unit",
    Weight.REMARK,
)

STEP_UNIT = Explanation(
    "A time step is probably in another unit, does not suit the loop, or does not divide that of the loop.",
    "The run is slow or inaccurate, or the robot reacts late; both sides must reach the end of each loop "
    "step exactly.",
    "Write steps with their unit; 20 ms is usual for the loop, and 1 to 5 ms for physics. Choose a loop step "
    "that is a multiple of the time steps of both sides.",
    "{n} time steps do not suit",
    Weight.REMARK,
)

POSE_UNIT = Explanation(
    "A pose in a model is probably in another unit.",
    "The part is far from where it should be, or turned.",
    'Write positions in m and angles in rad; SDF has `<pose degrees="true">`.',
    "{n} poses are probably in another unit",
    Weight.REMARK,
)

OWN_ROBOT_VIEW = Explanation(
    "A scanner or camera sees only its own robot.",
    "Its messages do not depend on the room.",
    "Move the sensor out of the shape that the message names, or turn it.",
    "{n} sensors see only their own robot",
    Weight.ALTERED,
)

WHEELS_WITHOUT_CONTACT = Explanation(
    "Wheels of a drive do not touch the ground.",
    "The wheels turn, and the robot does not move as commanded.",
    "Give each wheel a collision shape that reaches lower than the rest of the robot.",
    "{n} drives have wheels without contact",
    Weight.ALTERED,
)

TWO_CONTROLLERS = Explanation(
    "Two controllers, drives or plugins command one joint.",
    "They work against each other, or the last command counts.",
    "Remove one of them, name another joint, or on Gazebo leave the drive to it by `drive: plugin`.",
    "{n} joints have two controllers",
    Weight.ALTERED,
)

ROBOT_LOST = Explanation(
    "A robot of an experiment of the Neurorobotics Platform fell, flew away, or was thrown at the start.",
    "Whatever it was to do after this time is missing from the run.",
    "Correct the start pose, put missing meshes where the models are searched, or hold the joints that bear "
    "the robot.",
    "{n} robots fell, flew away or were thrown",
    Weight.INCOMPLETE,
)
