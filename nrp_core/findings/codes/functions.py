"""Findings about transfer functions."""

from nrp_core.findings.codes.explanation import Explanation, Weight

WRONG_DECLARATION = Explanation(
    "A file of transfer functions cannot be loaded, or a declaration or trigger in it is wrong.",
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
    "The parameters of a function are not `t` and one for each mapping.",
    "The time comes first; each other parameter gets its value from one mapping.",
    "Make `t` the first parameter, and give each other one the name in the first argument of one mapping.",
    "{n} functions whose parameters do not fit their mappings",
    Weight.ALTERED,
)

TWO_PUBLISHERS = Explanation(
    "Two functions publish on one topic, or two sources drive the same neurons.",
    "The later message overwrites the earlier; the effects of sources add up.",
    "Write from one function, or correct the topic or the indices.",
    "{n} topics or neurons with several sources",
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
    "A call, attribute, index, setting, message or operand does not fit the object that it is used on.",
    "The function raises an error at that line, or the topic or device refuses the value.",
    "Use what the message suggests; it lists the names, types or values that are possible.",
    "{n} calls, attributes, indices, settings, messages or operands do not fit",
    Weight.ALTERED,
)

NOT_REPRODUCIBLE = Explanation(
    "A function uses something outside the run: the wall clock, a global random generator, or the process.",
    "Two runs with the same seed will differ, or the run ends early.",
    "Use `t` for the time, and noise devices or a seeded generator in a variable for randomness; return to "
    "do nothing, and end a run with its `duration`.",
    "{n} functions use a clock, a random generator or a process outside the run",
    Weight.REMARK,
)

UNDEFINED_NAME = Explanation(
    "An undefined name.",
    "The function raises NameError at that line.",
    "Correct the spelling, import the module, or add the parameter and its mapping.",
    "{n} undefined names",
    Weight.ALTERED,
)

REASSIGNED_PARAMETER = Explanation(
    "A parameter is reassigned and then used as if it still had its original value.",
    "The assignment changes neither the variable nor the device; it only rebinds the name.",
    "Set an attribute: `count.value = ...`, `eye.rate = ...`, or use another name.",
    "{n} parameters are reassigned",
    Weight.REMARK,
)

HIDDEN_STATE = Explanation(
    "A function keeps state outside its variables.",
    "A reset or a snapshot leaves that state as it is.",
    "Keep state in a variable: `@nrp.MapVariable('count', initial_value=0)`.",
    "{n} places where functions keep state outside their variables",
    Weight.REMARK,
)

WRITES_FILE = Explanation(
    "A function writes a file.",
    "A replay writes the file again, and a reset does not restore it.",
    "Record values with the CSV recorder, `nrp.MapCSVRecorder`.",
    "{n} places where functions write files",
    Weight.REMARK,
)

MESSAGE_OVERWRITTEN = Explanation(
    "A function sends two messages on one topic in the same step.",
    "A topic keeps only the last message of a step, so the first one has no effect.",
    "Send one message with both values, or use separate topics.",
    "{n} messages are overwritten before they are used",
    Weight.REMARK,
)

NOT_KEPT = Explanation(
    "A variable does not keep its value from call to call.",
    "The function counts or sums, and starts again in every call.",
    "Change `name.value` itself, and do not set it at the beginning: `initial_value` does that once.",
    "{n} variables do not keep their values",
    Weight.REMARK,
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
    "A bound of a colour that no pixel meets.",
    "No colour is found, whatever the camera sees.",
    "Use OpenCV's scale: hue 0 to 179, saturation and value 0 to 255, the lower bound first.",
    "{n} bounds of colours that no pixel meets",
    Weight.ALTERED,
)

WRONG_TIME_STEP = Explanation(
    "A constant for the time between two calls of a function is not the step of the loop.",
    "Speeds, integrals and filters of the function are wrong by a factor.",
    "Take the time since the last call from `t`, or use the `timestep` of the experiment.",
    "{n} constants for the step of the loop are wrong",
    Weight.ALTERED,
)

BEYOND_SCANNER = Explanation(
    "A distance of a scanner is compared with a number beyond its range.",
    "The comparison has the same result for all distances; beams that reach nothing are `inf`.",
    "Use a distance within the range that `nrp inspect` lists.",
    "{n} distances are compared with numbers beyond the range of the scanner",
    Weight.ALTERED,
)
