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
    "A topic that does not exist, or has another type or direction.",
    "No message would arrive, or nothing would receive the published messages.",
    "Use the name and type in the message; subscribe to sensors, publish on the topics of drives.",
    "{n} uses of topics that do not fit the world",
    Weight.ALTERED,
)

ROBOT_LEFT_OUT = Explanation(
    "A robot is left out.",
    "The experiment runs without this robot; whatever the robot should sense or do is missing.",
    "Correct the cause that the message names: a missing file, or a file that cannot be read.",
    "{n} robots are left out",
    Weight.INCOMPLETE,
)

ROOM_LEFT_OUT = Explanation(
    "The room is left out and replaced by a plain floor.",
    "The objects and lights of the room are missing.",
    "Correct the cause that the message names: a missing file, or a file that cannot be read.",
    "{n} rooms are left out",
    Weight.INCOMPLETE,
)

MESH_REPLACED = Explanation(
    "A shape from a file is replaced by a simple shape.",
    "Cameras, rays and contacts use the simple shape; a shape may also be left out.",
    "Put the file where the models are searched, or correct it.",
    "{n} meshes are replaced by simple shapes",
    Weight.ALTERED,
)

APPEARANCE_REPLACED = Explanation(
    "A texture, material or colour is missing or not supported.",
    "Images show the part in another colour; its motion is unaffected.",
    "Add the file or the material, or give the part a plain colour.",
    "{n} textures, materials or colours are replaced",
    Weight.ALTERED,
)

PART_LEFT_OUT = Explanation(
    "A part of a robot or room is left out.",
    "The part is not simulated; the rest of the model is.",
    "Correct the part as the message says, or remove it from the file.",
    "{n} parts of models are left out",
    Weight.ALTERED,
)

UNKNOWN_PLUGIN = Explanation(
    "A plugin of a robot or room is not supported.",
    "Whatever the plugin would do in Gazebo does not happen here.",
    "No action is needed if the experiment does not need it; see docs/reference/scenes.md.",
    "{n} plugins have no effect",
    Weight.ALTERED,
)

SENSOR_NOT_SIMULATED = Explanation(
    "A sensor, or a property of a sensor, is not simulated.",
    "The sensor does not publish messages, or publishes other messages than the file describes.",
    "Use a supported sensor (docs/reference/scenes.md), or functions that do not need it.",
    "{n} sensors are not simulated as described",
    Weight.ALTERED,
)

VALUE_IGNORED = Explanation(
    "An element or value of a robot or room is ignored.",
    "The simulation does not have the effect that the element describes.",
    "No action is needed unless the effect matters; correct the name of an element if it is misspelled.",
    "{n} elements of models are ignored",
    Weight.ALTERED,
)

VALUE_REPLACED = Explanation(
    "A value of a robot or room is missing or impossible, and another value is used.",
    "The model is simulated with the value in the message.",
    "Write the intended value into the file.",
    "{n} values of models are replaced",
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
    "A part of a robot or room is renamed, because its name is already in use.",
    "Topics, services and recordings use the new name.",
    "Give each part a unique name.",
    "{n} parts of models are renamed",
    Weight.REMARK,
)

NO_SUBSCRIBER = Explanation(
    "Commands are published on a topic without a subscriber.",
    "The commands have no effect.",
    "Publish on a topic that `nrp inspect` lists for the robot, or add the drive that subscribes to it.",
    "{n} topics receive commands without a subscriber",
    Weight.ALTERED,
)

NO_PUBLISHER = Explanation(
    "A topic does not exist in the world, or does not have a publisher.",
    "Its subscribers do not receive messages unless a function publishes on the topic.",
    "Subscribe to a topic that `nrp inspect` lists for the robot, or add the sensor that publishes on it.",
    "{n} topics have no publisher",
    Weight.ALTERED,
)

STARTS_INSIDE = Explanation(
    "A robot starts inside the room or another robot.",
    "The physics engine pushes the robot out, often so fast that it is thrown metres away.",
    "Move the start pose so that the robot does not overlap anything; usually z is too low.",
    "{n} robots start inside the room or another robot",
    Weight.ALTERED,
)

NO_GROUND = Explanation(
    "There is no ground below a robot or below a movable model of the room at the start.",
    "The model falls. The drive of a falling robot has no effect; a floor falls with the objects on it.",
    "Add ground to the room, move the start pose above the ground, make fixed models `<static>`, or set "
    "the gravity of the room to 0.",
    "{n} models have no ground below them",
    Weight.ALTERED,
)

FELL_OUT = Explanation(
    "A robot has fallen out of the room.",
    "After that time its sensors and its drive have no objects to act on.",
    "Move the start pose above the ground, or make the ground larger.",
    "{n} robots have fallen out of the room",
    Weight.ALTERED,
)

NO_LIGHT = Explanation(
    "Cameras render light and shadows in a scene without a light.",
    "Their images are dark: only ambient light and glowing objects are visible.",
    "Add a <light> to the room, include model://sun, or use the raster renderer, which does not need lights.",
    "{n} scenes have no light",
    Weight.REMARK,
)

BEYOND_LIMIT = Explanation(
    "A command exceeds the limits of its joint or drive.",
    "A joint goes to its limit instead; a drive ignores motions it cannot perform, or moves unrealistically.",
    "Scale the command to the limits that `nrp inspect` lists, use m/s and rad/s, or change the robot file.",
    "{n} topics receive commands beyond the limits of their joint or drive",
    Weight.REMARK,
)

STARTS_HIGH = Explanation(
    "A robot starts several metres above the ground.",
    "Gravity makes the robot fall, and the impact can throw it over.",
    "Lower z of the start pose so that the robot begins on the ground.",
    "{n} robots start high above the ground",
    Weight.REMARK,
)

BELOW_GROUND = Explanation(
    "A model lies below the ground that robots stand on.",
    "Objects above the ground do not collide with it, and sensors do not detect it.",
    "Correct z of its pose; poses of models are in m, from the origin of the room.",
    "{n} models lie below the ground",
    Weight.REMARK,
)

STEP_OF_ENVIRONMENT = Explanation(
    "The time step of an environment differs from that of the experiment.",
    "Between two observations the brain runs for a longer or shorter time than the body.",
    "Set the time that the message names: `world: {options: {timestep: 50 ms}}`.",
    "{n} environments have another time step",
    Weight.REMARK,
)

OTHER_ENGINE = Explanation(
    "A part of a robot exists only in another physics engine.",
    "The world runs without it: its commands have no effect, it exerts no forces, and it has no inertia.",
    "Use the engine whose format describes it, for MJCF `world: {backend: mujoco}`.",
    "{n} parts of robots exist only in another engine",
    Weight.ALTERED,
)

FRAME_ELSEWHERE = Explanation(
    "A sensor names a frame in which its measurements would be misplaced.",
    "Its messages use a separate frame, which has the correct pose in the transform tree.",
    "Name a link at the pose of the sensor; for a camera, one with z forward, x right and y down.",
    "{n} sensors name frames that are elsewhere",
    Weight.REMARK,
)

TWO_DRIVES = Explanation(
    "A plugin of the simulator itself moves joints that a drive of nrp-core moves.",
    "They conflict, so the robot does not move as commanded.",
    "Remove one of them from the file, or leave the drive to the simulator, on Gazebo by `drive: plugin`.",
    "{n} plugins move joints that a drive moves",
    Weight.ALTERED,
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
    "The time step of the world is much shorter or longer than usual.",
    "The run is slow, or contacts and controllers are inaccurate.",
    "Write the unit of the step: `timestep: 1 ms`.",
    "{n} time steps are probably in another unit",
    Weight.REMARK,
)

POSE_UNIT = Explanation(
    "A pose is probably in another unit than m and rad.",
    "The part is at a wrong position or has a wrong orientation.",
    'Write positions in m and angles in rad; SDF has `<pose degrees="true">`, xacro has `${radians(90)}`.',
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
    "Two controllers, or a drive and a controller, command one joint.",
    "They work against each other, or the last command counts.",
    "Remove one of them, or name another joint.",
    "{n} joints have two controllers",
    Weight.ALTERED,
)
