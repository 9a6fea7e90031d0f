"""Rules of NRP-core 4: pools of datapacks, refusals, steps, messages of one's own, printed numbers."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import pytest
from configurations import Write, functions, python_engine
from golden import Golden
from nrp_client import NrpCore
from nrp_ebrains.reader import read_json

from nrp_core import Run, load_experiment, validate
from nrp_core.errors import ExperimentError, NrpError
from nrp_core.findings import InvalidExperimentError

TIMES = """
    from nrp_core.engines.python_json import EngineScript

    class Script(EngineScript):
        def initialize(self):
            self._registerDataPack("clock")
            self._registerDataPack("received")
            self._setDataPack("clock", {"time": 0})

        def runLoop(self, timestep_ns):
            received = self._getDataPack("received") or {}
            with open(f"{self._name}.txt", "a") as file:
                print(self._time_ns // 1_000_000, received.get("time"), file=file)
            self._setDataPack("clock", {"time": self._time_ns // 1_000_000})
"""
IMPORTS = """
    from nrp_core import *
    from nrp_core.data.nrp_json import *
"""
PREPARE = (
    IMPORTS
    + """
    @EngineDataPack(keyword="clock", id=DataPackIdentifier("clock", "slow"))
    @PreprocessingFunction("slow")
    def prepare(clock):
        made = JsonDataPack("{name}", "slow")
        made.data["time"] = {time}
        return [made]
"""
)
RELAY = (
    IMPORTS
    + """
    @{kind}(keyword="given", id=DataPackIdentifier("{name}", "slow"))
    @TransceiverFunction("fast")
    def relay(given):
        made = JsonDataPack("received", "fast")
        made.data["time"] = given.data["time"]
        return [made]
"""
)


def two_engines(*names: str, **more: Any) -> dict[str, Any]:
    return {
        "SimulationTimeout": 0.6,
        "EngineConfigs": [python_engine("fast", "times", 0.1), python_engine("slow", "times", 0.3)],
        "DataPackProcessingFunctions": functions(*names),
        **more,
    }


def run(path: Path) -> None:
    with Run(load_experiment(path)) as one:
        one.run()


def received(path: Path, engine: str = "fast") -> list[tuple[str, str]]:
    lines = path.with_name(f"{engine}.txt").read_text().splitlines()
    return [(time, value) for time, value in (line.split() for line in lines)]


def test_the_result_of_a_preprocessing_function_is_kept_until_the_next(write: Write) -> None:
    prepared = PREPARE.format(name="prepared", time='clock.data["time"]')
    relayed = RELAY.format(kind="PreprocessedDataPack", name="prepared")
    path = write(two_engines("prepare", "relay"), times=TIMES, prepare=prepared, relay=relayed)
    run(path)
    assert [value for _, value in received(path)] == ["0", "0", "0", "300", "300", "300"]


def test_a_datapack_of_an_engine_comes_before_one_of_its_name(write: Write) -> None:
    prepared = PREPARE.format(name="clock", time="-1")
    relayed = RELAY.format(kind="EngineDataPack", name="clock")
    path = write(two_engines("prepare", "relay"), times=TIMES, prepare=prepared, relay=relayed)
    run(path)
    assert [value for _, value in received(path)] == ["0", "0", "0", "300", "300", "300"]


STATUS = (
    IMPORTS
    + """
    @SimulationIteration(keyword="i")
    @StatusFunction()
    def status(i):
        seen = JsonRawData()
        seen.data["i"] = i
        return i in (1, 5), [seen]
"""
)


def test_only_the_last_iteration_says_whether_a_run_is_done(write: Write) -> None:
    status = {"Name": "status", "FileName": "status.py"}
    path = write(two_engines(StatusFunction=status), times=TIMES, status=STATUS)
    core = NrpCore("localhost:50051", str(path.parent))
    core.initialize()
    assert core.run_loop(3) == (False, [])
    assert core.run_loop(3) == (True, [{"i": i} for i in range(6)])
    core.shutdown()


SENT = (
    IMPORTS
    + """
    @EngineDataPack(keyword="sent", id=DataPackIdentifier("received", "fast"), isPreprocessed=True)
    @StatusFunction()
    def status(sent):
        seen = JsonRawData()
        seen.data["time"] = sent.data["time"]
        return False, [seen]
"""
)


def test_a_status_function_sees_the_datapacks_of_transceiver_functions(write: Write) -> None:
    relayed = RELAY.format(kind="EngineDataPack", name="clock")
    status = {"Name": "status", "FileName": "status.py"}
    path = write(two_engines("relay", StatusFunction=status), times=TIMES, relay=relayed, status=SENT)
    core = NrpCore("localhost:50051", str(path.parent))
    core.initialize()
    done, timeout, seen = core.run_until_timeout()
    core.shutdown()
    assert (done, timeout) == (False, True)
    assert seen == [{"time": 0}] * 3 + [{"time": 300}] * 3


def test_two_functions_of_one_name_are_refused(write: Write, golden: Golden) -> None:
    relayed = RELAY.format(kind="EngineDataPack", name="clock")
    path = write(two_engines("relay", "relay"), times=TIMES, relay=relayed)
    with golden.raises(InvalidExperimentError, match="relay"):
        read_json(path)


OTHERS = {
    "reads": PREPARE.format(name="made", time="0").replace('Function("slow")', 'Function("fast")'),
    "returns": PREPARE.format(name="made", time="0").replace('JsonDataPack("made", "slow")',
                                                            'JsonDataPack("made", "fast")'),
    "no list": RELAY.format(kind="EngineDataPack", name="clock").replace("[made]", "made"),
}  # fmt: skip


@pytest.mark.parametrize("wrong", OTHERS)
def test_functions_with_datapacks_that_they_must_not_have_are_refused(
    wrong: str, write: Write, golden: Golden
) -> None:
    path = write(two_engines("function"), times=TIMES, function=OTHERS[wrong])
    with golden.raises(NrpError, match="function"):
        run(path)


@pytest.mark.parametrize("step_s", [0.005, 0.003, 0.001, 0.0001, 0.25])
def test_engines_have_any_step(step_s: float, write: Write) -> None:
    config = {"SimulationTimeout": 4 * step_s, "EngineConfigs": [python_engine("fast", "steps", step_s)]}
    path = write(config, steps=TIMES.replace(" // 1_000_000,", ","))
    run(path)
    assert [int(time) for time, _ in received(path)] == [round(k * step_s * 1e9) for k in (1, 2, 3, 4)]


@pytest.mark.parametrize(
    ("asked", "expected"),
    [("<max_step_size>0.001</max_step_size>", 1_000_000), ("<max_step_size>0.003</max_step_size>", 2_500_000),
     ("", 2_000_000)],
)  # fmt: skip
def test_the_physics_has_the_step_of_the_world_file(asked: str, expected: int, write: Write) -> None:
    gazebo = {"EngineType": "gazebo_grpc", "EngineName": "g", "GazeboWorldFile": "world.sdf"}
    path = write({"SimulationTimeout": 1, "EngineConfigs": [gazebo]})
    plugin = '<plugin name="w" filename="NRPGazeboGrpcWorldPlugin.so"/>'
    text = f'<sdf version="1.6"><world name="w"><physics type="ode">{asked}</physics>{plugin}</world></sdf>'
    path.with_name("world.sdf").write_text(text)
    experiment = read_json(path)
    assert experiment.world.options["timestep"] == f"{expected} ns"
    assert experiment.maker is not None
    assert not experiment.maker.room(experiment).warnings


PROTO = """
syntax = "proto3";
package Own;  // a comment
/* two kinds */
enum Colour { RED = 0; BLUE = 1; }
message Point { double x = 1; repeated float parts = 2; }
message Seen {
  uint32 number = 1; string text = 2; Colour colour = 3; Point at = 4; bool big = 5; float small = 6;
}
"""
MESSENGER = """
    from nrp_core.engines.python_grpc import GrpcEngineScript
    import own_pb2

    class Script(GrpcEngineScript):
        def initialize(self):
            self._registerDataPack("seen", own_pb2.Seen)
            self._getDataPack("seen").at.parts.extend([0.5, 1.5])

        def runLoop(self, timestep_ns):
            seen = self._getDataPack("seen")
            seen.number, seen.text, seen.colour, seen.big, seen.small = 7, "seven", 1, True, 1.1141424e-05
"""
DUMP = """
    from nrp_core import *
    from own import OwnSeenDataPack

    @EngineDataPack(keyword="seen", id=DataPackIdentifier("seen", "messenger"))
    @TransceiverFunction("sink")
    def dump(seen):
        assert list(seen.data.at.parts) == [0.5, 1.5]
        made = OwnSeenDataPack("seen", "sink")
        made.data.CopyFrom(seen.data)
        return [made]
"""


def test_own_messages_are_compiled_and_printed_as_in_nrp_core_4(write: Write) -> None:
    sink = {
        "EngineType": "datatransfer_grpc_engine", "EngineName": "sink",
        "dumps": [{"name": "seen", "file": True}],
    }  # fmt: skip
    config = {
        "SimulationTimeout": 0.02,
        "EngineConfigs": [python_engine("messenger", "messenger", kind="python_grpc"), sink],
        "DataPackProcessingFunctions": functions("dump"),
    }
    path = write(config, messenger=MESSENGER, dump=DUMP)
    path.with_name("own.proto").write_text(PROTO)
    run(path)
    (file,) = path.parent.glob("data/*/seen-0.data")
    head, first, second = re.sub(r"parts: 0\.5\nparts: 1\.5\n", "P", file.read_text()).splitlines()
    assert head == "sim_time,number,text,colour,at,big,small"
    assert first == "0,0,,0,P,0,0.000000"
    assert second == "0.01,7,seven,1,P,1,0.000011"


def test_a_file_of_messages_that_is_not_understood_is_refused(write: Write, golden: Golden) -> None:
    path = write({"SimulationTimeout": 1, "EngineConfigs": [python_engine("messenger", "messenger")]})
    path.with_name("messenger.py").write_text("")
    path.with_name("own.proto").write_text(PROTO + "service Finder { }")
    with golden.raises(ExperimentError, match=r"own\.proto"):
        run(path)


LOOPED = """
    from nrp_core.data.nrp_json import JsonDataPack
    from nrp_core.event_loop import *

    @Clock("clock")
    @Iteration("iteration")
    @InputDummy("dummy", "id", 3)
    @FunctionalNode(name="source", outputs=["both"])
    def source(clock, iteration, dummy):
        return [(clock, iteration, dummy)]

    @FromEngine("state", "/slow/clock")
    @FromFunctionalNode("both", "/source/both")
    @ToEngine("out", "/fast")
    @OutputDummy("out", "id")
    @FunctionalNode(name="sink", outputs=["out"])
    def sink(state, both):
        made = JsonDataPack("received", "fast")
        made.data["time"] = f"{both[0]}/{both[2]}/{state.data['time']}/{state.isUpdated()}"
        return [made]
"""


def test_an_event_loop_runs_in_lockstep_and_says_so(write: Write) -> None:
    """Engines of 100 and 300 ms and a graph every 200 ms share one grid; a datapack is new to one graph."""
    looped = {
        "SimulationLoop": "EventLoop",
        "EventLoop": {"Timestep": 0.2, "Timeout": 0.6},
        "ComputationalGraph": ["looped.py"],
    }
    config = {**two_engines(), "SimulationTimeout": 0, **looped}
    path = write(config, times=TIMES, looped=LOOPED)
    findings = validate(path)
    assert [one.line for one in findings if "lockstep" in one.message] == [18]
    run(path)
    assert [value for _, value in received(path)] == [
        "0/3/0/True", "0/3/0/True", "200/3/0/False", "200/3/0/False", "400/3/300/True", "400/3/300/True",
    ]  # fmt: skip


CHAT = """
    from nrp_core.data.nrp_json import JsonDataPack, NlohmannJson
    from nrp_core.data.nrp_protobuf import GazeboJoint
    from nrp_core.event_loop import *

    always = node_policies.functional_node.exec_policy.always
    seen = []

    @MQTTSubscriber("text", "lab/text", str)
    @MQTTSubscriber("joint", "lab/joint", GazeboJoint)
    @MQTTSubscriber("parsed", "lab/json", NlohmannJson)
    @FunctionalNode("listener")
    def listen(text, joint, parsed):
        seen.append((text, joint.position, parsed["n"]))

    @Iteration("n")
    @MQTTPublisher("text", "lab/text", str)
    @MQTTPublisher("joint", "lab/joint", GazeboJoint)
    @MQTTPublisher("json", "lab/json", str)
    @OutputDummy("text", "end", compute_period=3)
    @FunctionalNode("speaker", ["text", "joint", "json"], exec_policy=always)
    def speak(n):
        assert seen == [(f"at {i}", i, i) for i in range(n)], seen
        return [f"at {n}", GazeboJoint(position=n), '{"n": %d}' % n]
"""
COUNTED = """
    from nrp_core.event_loop import *

    counts = [0, 0]
    always = node_policies.functional_node.exec_policy.always

    @OutputDummy("done", "rare", compute_period=3)
    @FunctionalNode("rare", ["done"], exec_policy=always)
    def rare():
        counts[0] += 1
        return [0]

    @FunctionalNode("unused", ["nothing"], exec_policy=always)
    def unused():
        counts[1] += 1
        return [0]

    @Iteration("n")
    @OutputDummy("done", "each")
    @FunctionalNode("each", ["done"], exec_policy=always)
    def each(n):
        assert counts == [n // 3 + 1, 0], counts
        with open("counts.txt", "a") as file:
            return [file.write(f"{n} ")]
"""


def without_engines(**more: Any) -> dict[str, Any]:
    return {"SimulationLoop": "EventLoop", "EventLoop": {"Timestep": 0.1, "Timeout": 1.0, **more}}


def test_messages_of_mqtt_reach_the_nodes_of_the_next_iteration(write: Write) -> None:
    run(write(without_engines() | {"ComputationalGraph": ["chat.py"]}, chat=CHAT))


def test_an_output_driven_event_loop_computes_each_output_after_its_period(write: Write) -> None:
    loop = without_engines(ExecutionMode="OutputDriven")
    path = write(loop | {"ComputationalGraph": ["counted.py"]}, counted=COUNTED)
    run(path)
    assert path.with_name("counts.txt").read_text().split() == [str(i) for i in range(10)]


RARELY = """
    from nrp_core.event_loop import *

    read = []
    always = node_policies.functional_node.exec_policy.always

    @Iteration("n")
    @MQTTPublisher("text", "lab/text", str)
    @FunctionalNode("speaker", ["text", "number"], exec_policy=always)
    def speak(n):
        return [f"at {n}", n] if n in (0, 4) else None

    @FromFunctionalNode("number", "/speaker/number")
    @MQTTSubscriber("text", "lab/text", str)
    @OutputDummy("done", "rare", compute_period=3)
    @FunctionalNode("rare", ["done"])
    def rare(text, number):
        read.append((text, number))

    @MQTTSubscriber("text", "lab/text", str)
    @OutputDummy("done", "rarer", compute_period=2)
    @FunctionalNode("rarer", ["done"])
    def rarer(text):
        read.append(text)

    @Iteration("n")
    @OutputDummy("done", "each")
    @FunctionalNode("each", ["done"], exec_policy=always)
    def each(n):
        with open("read.txt", "w") as file:
            file.write(str(read))

    @FromFunctionalNode("number", "/speaker/number")
    @OutputDummy("done", "often")
    @FunctionalNode("often", ["done"])
    def often(number):
        pass
"""


def test_a_message_waits_until_its_node_is_computed(write: Write) -> None:
    path = write(
        without_engines(ExecutionMode="OutputDriven") | {"ComputationalGraph": ["rarely.py"]}, rarely=RARELY
    )
    run(path)
    read = path.with_name("read.txt").read_text()
    assert read == str([(None, 0), "at 0", ("at 0", 0), ("at 4", 4), "at 4"])


@pytest.mark.parametrize(
    ("before", "after", "words"),
    [
        ("'{\"n\": %d}' % n", "'{'", "lab/json"),
        ("compute_period=3", "compute_period=0", "at least 1"),
    ],
)
def test_mistakes_in_graphs_are_errors_that_name_them(
    before: str, after: str, words: str, write: Write
) -> None:
    path = write(without_engines() | {"ComputationalGraph": ["chat.py"]}, chat=CHAT.replace(before, after))
    with pytest.raises(NrpError, match=words):
        run(path)


BESIDE = """
    from nrp_core.data.nrp_json import JsonDataPack
    from nrp_core.event_loop import *

    @MQTTSubscriber("clock", "slow/get/clock", JsonDataPack)
    @MQTTPublisher("out", "fast/set/received", JsonDataPack)
    @FunctionalNode("node", ["out"])
    def node(clock):
        made = JsonDataPack("received", "fast")
        made.data["time"] = clock.data["time"]
        return [made]
"""


def beside(path: Path, name: str, step_s: float) -> dict[str, Any]:
    engine = {"EngineName": name, "PythonFileName": "times.py"}
    path.with_name(f"{name}.json").write_text(json.dumps({"Timestep": step_s, "EngineConfig": engine}))
    return {"ProcCmd": "async_python_json_engine.py", "ProcStartParams": [f"--config={name}.json"]}


def test_engines_beside_an_event_loop_exchange_datapacks_by_their_topics(write: Write) -> None:
    config = without_engines() | {"ComputationalGraph": ["beside.py"], "MQTTNode": {}}
    path = write(config, times=TIMES, beside=BESIDE)
    programs = [beside(path, "fast", 0.1), beside(path, "slow", 0.3), {"ProcCmd": "roslaunch room.launch"}]
    path.write_text(json.dumps(config | {"ExternalProcesses": programs}))
    assert [one.message for one in validate(path) if "roslaunch" in one.message]
    run(path)
    assert [value for _, value in received(path)] == [str(300 * (i // 3)) for i in range(10)]


def test_an_engine_beside_an_event_loop_needs_its_file(write: Write, golden: Golden) -> None:
    path = write(without_engines())
    programs = [beside(path, "fast", 0.1)]
    path.with_name("fast.json").unlink()
    path.write_text(json.dumps(without_engines() | {"ComputationalGraph": [], "ExternalProcesses": programs}))
    with golden.raises(InvalidExperimentError, match=r"fast\.json"):
        read_json(path)
