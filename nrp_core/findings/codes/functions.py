"""Findings about transfer functions."""

from nrp_core.findings.codes.explanation import Explanation, Weight

WRONG_DECLARATION = Explanation(
    "A file of transfer functions cannot be loaded, or a declaration in it is wrong.",
    "The function is not connected to brain and robot as intended.",
    "Correct the line in the message; docs/reference/transfer-functions.md shows how functions are declared.",
    "{n} files or declarations of transfer functions are wrong",
    Weight.ALTERED,
)

NO_SUCH_IMPORT = Explanation(
    "An imported module or name does not exist.",
    "The file cannot be loaded; a file of the Neurorobotics Platform is loaded anyway and fails "
    "where it uses the missing name.",
    "Correct the name, put the module next to the file, or install its package.",
    "{n} imports of something that does not exist",
    Weight.ALTERED,
)

MAPPING_MISMATCH = Explanation(
    "A parameter and its mapping do not match.",
    "Each parameter except `t` needs exactly one mapping, which provides its value.",
    "Give each parameter the name in the first argument of one mapping.",
    "{n} parameters without a matching mapping",
    Weight.ALTERED,
)

NO_TIME = Explanation(
    "The first parameter is not the time, `t`.",
    "The loop passes the time first, so all other parameters would be shifted.",
    "Make `t` the first parameter, even if the body does not use it.",
    "{n} functions do not begin with the parameter `t`",
    Weight.ALTERED,
)

WRONG_DIRECTION = Explanation(
    "A device is used in the wrong direction.",
    "MapSpikeSink reads neurons and MapSpikeSource drives them; a device does only one of these.",
    "Change the mapping or the kind of device.",
    "{n} devices are used in the wrong direction",
    Weight.ALTERED,
)

NO_SUCH_ATTRIBUTE = Explanation(
    "A device, topic or variable does not have this attribute.",
    "The function raises AttributeError at that line.",
    "Use an existing attribute: `rate` of a Poisson source, `voltage` of a leaky integrator, "
    "`value` of a topic or variable.",
    "{n} uses of attributes that do not exist",
    Weight.ALTERED,
)

READ_ONLY = Explanation(
    "A read-only attribute is set.",
    "Sinks and subscribed topics only report values; setting them has no effect.",
    "Set a source, publish on a topic, or keep the value in a variable.",
    "{n} read-only attributes are set",
    Weight.ALTERED,
)

WRONG_SETTING = Explanation(
    "A setting of a device that does not exist or is out of range.",
    "The device rejects it: rates and deviations must not be negative, and all values must be finite.",
    "Use a setting and a value that the message allows.",
    "{n} wrong settings of devices",
    Weight.ALTERED,
)

NO_SUCH_FIELD = Explanation(
    "A message does not have this field.",
    "The function raises AttributeError at that line.",
    "Use a field of the message type; the finding lists them.",
    "{n} uses of message fields that do not exist",
    Weight.ALTERED,
)

WRONG_MESSAGE = Explanation(
    "The arguments of a message do not fit its fields.",
    "The message cannot be created, or its topic rejects it.",
    "Give the fields in order or by name, each with the correct type.",
    "{n} messages with arguments that do not fit",
    Weight.ALTERED,
)

WRONG_MESSAGE_TYPE = Explanation(
    "The type of a message differs from the type of its topic.",
    "The topic rejects the message when it is published.",
    "Publish a message of the topic's type, or correct the type of the topic.",
    "{n} messages of another type than their topic",
    Weight.ALTERED,
)

TWO_PUBLISHERS = Explanation(
    "Two functions publish on one topic.",
    "In a step in which both run, the later one overwrites the earlier.",
    "Publish the sum from one function, or use a separate topic for each function.",
    "{n} topics with several publishing functions",
    Weight.REMARK,
)

TWO_SOURCES = Explanation(
    "Two sources of the same kind drive the same neurons.",
    "Their effects add up, which is rarely intended.",
    "Use one source, or correct the indices.",
    "{n} pairs of sources drive the same neurons",
    Weight.REMARK,
)

SILENT_SOURCE = Explanation(
    "A source that is never set.",
    "The source stays silent for the whole run.",
    "Set its rate or amplitude in the body, or in the mapping: `MapSpikeSource(..., nrp.poisson, "
    "rate=10.0)`.",
    "{n} sources are never set",
    Weight.REMARK,
)

WRONG_UNIT = Explanation(
    "A quantity in one unit is used as a quantity in another unit.",
    "This is correct only if a factor has the missing unit; such a factor should have a name.",
    "Check the gain: `rate_hz = GAIN_HZ_PER_MV * sink.voltage`.",
    "{n} quantities are used in another unit",
    Weight.REMARK,
)

SAME_NAME = Explanation(
    "Two transfer functions have the same name.",
    "Reports and recordings identify a function by its name.",
    "Rename one of them.",
    "{n} transfer functions share their names",
    Weight.ALTERED,
)

RETURN_VALUE = Explanation(
    "The return value of a function does not match its topic.",
    "A value without a topic is lost, and a topic without a value does not publish messages.",
    "Return a message, or name a topic: `@nrp.Neuron2Robot(Topic(...))`.",
    "{n} return values do not match their topic",
    Weight.REMARK,
)

DELAY = Explanation(
    "The delay from a sensor to an actuator.",
    "Each pass through the brain and each step of the loop delays the behaviour.",
    "Use a shorter time step of the loop to reduce the delay.",
    "{n} delays from a sensor to an actuator",
    Weight.REMARK,
)

NOT_CHECKED = Explanation(
    "A value is known only at run time.",
    "The check does not execute transfer functions, so it skips everything that depends on this value.",
    "No action is needed; a literal value would allow the check.",
    "{n} values are known only at run time",
    Weight.REMARK,
)

WRONG_CALL = Explanation(
    "A call has arguments that the function does not accept.",
    "The function raises TypeError at that line.",
    "Call it as the message shows.",
    "{n} calls with arguments that do not fit",
    Weight.ALTERED,
)

NO_SUCH_NAME = Explanation(
    "A module does not have this name.",
    "The function raises AttributeError at that line.",
    "Use the suggested name.",
    "{n} uses of names that a module does not have",
    Weight.ALTERED,
)

NOT_REPRODUCIBLE = Explanation(
    "A function depends on the wall clock or on a global random generator.",
    "Two runs with the same seed will differ; while a function sleeps, simulated time does not advance.",
    "Use `t` for the time, and noise devices or a seeded generator in a variable for randomness.",
    "{n} functions depend on the wall clock or on a global random generator",
    Weight.REMARK,
)

WRONG_TRIGGER = Explanation(
    "A trigger is neither a subscribed topic nor a spike recorder.",
    "Only these trigger a function; this one would never run, or cannot be bound.",
    "Name parameters of MapRobotSubscriber, or of MapSpikeSink with nrp.spike_recorder, or omit `triggers`.",
    "{n} wrong triggers",
    Weight.ALTERED,
)

UNDEFINED_NAME = Explanation(
    "An undefined name.",
    "The function raises NameError at that line.",
    "Correct the spelling, import the module, or add the parameter and its mapping.",
    "{n} undefined names",
    Weight.ALTERED,
)

NOT_A_NUMBER = Explanation(
    "A device, a topic or a message is used as a number.",
    "The function raises TypeError at that line.",
    "Use its value: `camera.value`, `wheel.voltage`, `message.data`.",
    "{n} objects are used as numbers",
    Weight.ALTERED,
)

WRONG_INDEX = Explanation(
    "An index is applied to an object without items, or is out of range.",
    "The function raises TypeError or IndexError at that line.",
    "Index only lists and device groups, from 0; a number, a message and a single device have no items.",
    "{n} wrong indices",
    Weight.ALTERED,
)

REASSIGNED_PARAMETER = Explanation(
    "A parameter is reassigned and then used as if it still had its original value.",
    "The assignment changes neither the variable nor the device; it only rebinds the name.",
    "Set an attribute: `count.value = ...`, `eye.rate = ...`, or use another name.",
    "{n} parameters are reassigned",
    Weight.REMARK,
)

WRONG_ROW = Explanation(
    "A row does not match the headers of its file.",
    "Values appear in the wrong columns.",
    "Record one value for each header; headers are a list of strings.",
    "{n} rows do not match their headers",
    Weight.ALTERED,
)

HIDDEN_STATE = Explanation(
    "A function keeps state outside its variables.",
    "A reset or a restored snapshot does not restore that state, so the next run starts differently.",
    "Keep it in a variable: `@nrp.MapVariable('count', initial_value=0)`, and use `count.value`.",
    "{n} places where functions keep state outside their variables",
    Weight.REMARK,
)

ENDS_PROCESS = Explanation(
    "A function ends the process, or handles its signals.",
    "The loop, the brain and the world share that process: the run ends early, or cannot be interrupted.",
    "Return from the function to do nothing; limit a run with its `duration` or with `--until`.",
    "{n} places where functions end the process or handle its signals",
    Weight.ALTERED,
)

WRITES_FILE = Explanation(
    "A function writes a file.",
    "A reset does not empty the file, a replay writes it again, and a sandboxed run may not write it.",
    "Record values with `nrp.MapCSVRecorder`: a recording of the run contains its rows.",
    "{n} places where functions write files",
    Weight.REMARK,
)

FILE_RENAMED = Explanation(
    "A CSV recorder names a file outside the folder of the run.",
    "Rows are written only below that folder, where a recording and its replay find them.",
    "Give a name without a leading `/` and without `..`: `rows.csv` or `arm/rows.csv`.",
    "{n} CSV files are outside the folder of the run",
    Weight.ALTERED,
)

PARAMETER_WITHOUT_EFFECT = Explanation(
    "A declared parameter is never used.",
    "An experiment or a sweep can set it, and every value gives the same result.",
    "Use the name that the declaration is assigned to, or remove the declaration.",
    "{n} parameters have no effect",
    Weight.REMARK,
)

MESSAGE_OVERWRITTEN = Explanation(
    "A function sends two messages on one topic in the same step.",
    "A topic keeps only the last message of a step, so the first one has no effect.",
    "Send one message with both values, or use separate topics.",
    "{n} messages are overwritten before they are used",
    Weight.REMARK,
)

COMMAND_IGNORED = Explanation(
    "A part of a command that the drive does not use.",
    "This part of the command has no effect.",
    "Use the components that the message names, or another drive, such as `planar_move` for sideways motion.",
    "{n} parts of commands are ignored by their drives",
    Weight.REMARK,
)

NOT_KEPT = Explanation(
    "A variable does not keep its value from call to call.",
    "The function counts or sums, and starts again in every call.",
    "Change `name.value` itself, and do not set it at the beginning: `initial_value` does that once.",
    "{n} variables do not keep their values",
    Weight.REMARK,
)

NO_SUCH_JOINT = Explanation(
    "A function looks up a joint that the robot does not have.",
    "`index` raises an error in the first step, and a test with `in` is never true.",
    "Use one of the robot's joints; `nrp inspect` lists them.",
    "{n} names are not joints of the robot",
    Weight.REMARK,
)

LOST_NUMBER = Explanation(
    "A variable of a transfer function has become NaN.",
    "NumPy returns NaN for the mean of an empty array and for 0 / 0, and every result of NaN is NaN.",
    "Check for an empty input, for example with `if len(values)`, before the variable is set.",
    "{n} variables have become NaN",
    Weight.ALTERED,
)

MESSAGE_NOT_SENT = Explanation(
    "A message is created but not sent, or changed after it was sent.",
    "Subscribers do not receive the message or its last values.",
    "Return the message, or pass it to `send_message` when all its fields are set.",
    "{n} messages are not sent or changed too late",
    Weight.ALTERED,
)

NO_PREPROCESSED_RESULT = Explanation(
    "The function of a preprocessed topic does not return a value.",
    "The value of the topic is its result, which is always None.",
    "Return the converted message.",
    "{n} functions of preprocessed topics do not return a value",
    Weight.ALTERED,
)

WAITS = Explanation(
    "A transfer function waits.",
    "Simulated time advances only between calls, so the wait has no effect or never ends.",
    "Return, and act in a later call: compare `t` with a time stored in a variable.",
    "{n} transfer functions wait",
    Weight.ALTERED,
)

IMPOSSIBLE_COLOUR = Explanation(
    "The bounds of a colour do not match any pixel, or have another scale.",
    "The colour is never found. In OpenCV, hues are 0 to 179, saturations and values 0 to 255.",
    "Write the bounds in OpenCV's scale, the lower one first.",
    "{n} colours are never found",
    Weight.ALTERED,
)

BEYOND_SCANNER = Explanation(
    "A distance is compared with a value beyond the range of its scanner.",
    "The comparison has the same result for all distances; a beam without a hit is `inf`.",
    "Compare with a distance within the range of the scanner, or with `inf`.",
    "{n} comparisons are beyond the range of a scanner",
    Weight.ALTERED,
)

OTHER_STEP = Explanation(
    "A constant time step differs from the period of the function.",
    "Integrals and derivatives that use it are wrong by a factor.",
    "Compute the step from `t`, or set `timestep` of the experiment to it.",
    "{n} constant time steps differ from that of the loop",
    Weight.ALTERED,
)
