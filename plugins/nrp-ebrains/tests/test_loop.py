"""Order and time of functions and engines, as the loop of NRP-core 4 has them."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from configurations import Write, functions, python_engine

from nrp_core import Run, load_experiment

CLOCK = """
    from nrp_core.engines.python_json import EngineScript

    class Script(EngineScript):
        def initialize(self):
            self._registerDataPack("clock")
            self._setDataPack("clock", {"time": self._time_ns})

        def runLoop(self, timestep_ns):
            self._setDataPack("clock", {"time": self._time_ns})
"""
BRAIN = """
    import nest
    nest.ResetKernel()
"""
COUNT = """
    from nrp_core import *

    @TransceiverFunction("{engine}")
    def count():
        counts["{engine}"] += 1
        return []
"""
WATCH = """
    import json
    from nrp_core import *

    counts = dict.fromkeys(["one", "two", "brain", "three"], 0)
    rows = []

    @EngineDataPack(keyword="one", id=DataPackIdentifier("clock", "one"))
    @EngineDataPack(keyword="two", id=DataPackIdentifier("clock", "two"))
    @EngineDataPack(keyword="kernel", id=DataPackIdentifier("kernel", "brain"))
    @EngineDataPack(keyword="three", id=DataPackIdentifier("clock", "three"))
    @TransceiverFunction("one")
    def watch(one, two, kernel, three):
        brain = round(kernel.data["biological_time"] * 1e6)
        times = one.data["time"], two.data["time"], brain, three.data["time"]
        rows.append(list(zip(counts.values(), times)))
        counts["one"] += 1
        with open("rows.json", "w") as file:
            json.dump(rows, file)
        return []
"""


def run(path: Path) -> None:
    with Run(load_experiment(path)) as one:
        one.run()


def test_engines_with_four_rates_synchronise_as_in_nrp_core_4(write: Write) -> None:
    path = write(
        {
            "SimulationTimeout": 1,
            "EngineConfigs": [
                python_engine("one", "clock", 0.01),
                python_engine("two", "clock", 0.02),
                {
                    "EngineType": "nest_json", "EngineName": "brain", "EngineTimestep": 0.04,
                    "NestInitFileName": "brain.py",
                },
                python_engine("three", "clock", 0.08),
            ],
            "DataPackProcessingFunctions": functions("watch", "count_two", "count_brain", "count_three"),
        },
        clock=CLOCK, brain=BRAIN, watch=WATCH, **{
            f"count_{one}": COUNT.format(engine=one) for one in ("two", "brain", "three")
        },
    )  # fmt: skip
    run(path)
    rows = json.loads(path.with_name("rows.json").read_text())
    # at iteration k an engine with a step of s has taken k // s steps, and its function ran once more
    expected = [
        [[k // s + (s > 1) if k else 0, k // s * s * 10_000_000] for s in (1, 2, 4, 8)] for k in range(100)
    ]
    assert rows == expected


LISTEN = """
    from nrp_core.engines.python_json import EngineScript

    class Script(EngineScript):
        def initialize(self):
            self._registerDataPack("received")

        def runLoop(self, timestep_ns):
            with open("received.txt", "a") as file:
                print(self._getDataPack("received")["time"], file=file)
"""
NODES = """
    import json
    from nrp_core.data.nrp_json import JsonDataPack
    from nrp_core.event_loop import *

    counts, rows = [0, 0], []
    always = node_policies.functional_node.exec_policy.always

    @FunctionalNode(name="fast", outputs=["count"], exec_policy=always)
    def fast():
        counts[0] += 1
        return [counts[0]]

    @ToEngine(keyword="out", address="/slow")
    @FunctionalNode(name="slow", outputs=["out"], exec_policy=always)
    def slow():
        counts[1] += 1
        return [None]

    @FromEngine(keyword="clock", address="/slow/clock")
    @FromFunctionalNode(keyword="count", address="/fast/count")
    @ToEngine(keyword="received", address="/one")
    @FunctionalNode(name="join", outputs=["received"])
    def join(clock, count):
        rows.append([count, counts[1], clock.data["time"], clock.isUpdated()])
        with open("rows.json", "w") as file:
            json.dump(rows, file)
        sent = JsonDataPack("received", "any")
        sent.data["time"] = count
        return [sent]

    @FromEngine(keyword="clock", address="/slow/clock")
    @ToEngine(keyword="received", address="/one")
    @FunctionalNode(name="seldom", outputs=["received"])
    def seldom(clock):
        assert clock.isUpdated()
        return None
"""


def test_a_graph_runs_nodes_for_the_engines_that_are_due(write: Write) -> None:
    path = write(
        {
            "SimulationTimeout": 0.06,
            "DataPackProcessor": "cg",
            "EngineConfigs": [python_engine("one", "listen", 0.01), python_engine("slow", "clock", 0.02)],
            "ComputationalGraph": ["nodes.py"],
        },
        listen=LISTEN, clock=CLOCK, nodes=NODES,
    )  # fmt: skip
    run(path)
    rows = json.loads(path.with_name("rows.json").read_text())
    # 'slow' runs with its engine, every second time, and comes first where both engines are due
    expected = [[k + 1, k // 2 + 1, k // 2 * 20_000_000, k % 2 == 0] for k in range(6)]
    assert rows == expected
    assert path.with_name("received.txt").read_text().split() == [str(k + 1) for k in range(6)]


RELAY = """
    from nrp_core import *
    from nrp_core.data.nrp_json import JsonDataPack

    @EngineDataPack(keyword="clock", id=DataPackIdentifier("clock", "one"))
    @TransceiverFunction("two")
    def relay(clock):
        sent = JsonDataPack("received", "two")
        for key in clock.data.keys():
            sent.data[key] = clock.data[key]
        return [sent]
"""


def test_a_datapack_arrives_one_step_later(write: Write) -> None:
    path = write(
        {
            "SimulationTimeout": 0.1,
            "EngineConfigs": [python_engine("one", "clock"), python_engine("two", "listen")],
            "DataPackProcessingFunctions": functions("relay"),
        },
        clock=CLOCK, relay=RELAY, listen=LISTEN,
    )  # fmt: skip
    run(path)
    received = path.with_name("received.txt").read_text().split()
    assert received == [str(k * 10_000_000) for k in range(10)]


PREPROCESS = """
    from nrp_core import *
    from nrp_core.data.nrp_json import JsonDataPack

    @EngineDataPack(keyword="clock", id=DataPackIdentifier("clock", "one"))
    @PreprocessingFunction("one")
    def halve(clock):
        half = JsonDataPack("half", "one")
        half.data["time"] = clock.data["time"] // 2
        return [half]
"""
USE_HALF = """
    from nrp_core import *
    from nrp_core.data.nrp_json import JsonDataPack

    @PreprocessedDataPack(keyword="half", id=DataPackIdentifier("half", "one"))
    @SimulationIteration(keyword="n")
    @SimulationTime(keyword="t_ns")
    @TransceiverFunction("two")
    def use(half, n, t_ns):
        assert t_ns == n * 10_000_000
        sent = JsonDataPack("received", "two")
        sent.data["time"] = half.data["time"]
        return [sent]
"""


def test_preprocessing_functions_run_first(write: Write) -> None:
    path = write(
        {
            "SimulationTimeout": 0.03,
            "EngineConfigs": [python_engine("two", "listen"), python_engine("one", "clock")],
            "DataPackProcessingFunctions": functions("use_half", "halve"),
        },
        clock=CLOCK, listen=LISTEN, use_half=USE_HALF, halve=PREPROCESS,
    )  # fmt: skip
    run(path)
    assert path.with_name("received.txt").read_text().split() == ["0", "5000000", "10000000"]


MESSAGES = """
    from nrp_core.engines.python_grpc import GrpcEngineScript
    from nrp_protobuf import nrpgenericproto_pb2, wrappers_pb2

    class Script(GrpcEngineScript):
        def initialize(self):
            self._registerDataPack("array", nrpgenericproto_pb2.ArrayFloat)
            self._registerDataPack("answer", wrappers_pb2.DoubleValue)
            self._getDataPack("array").array.extend([0.1, 2.5])

        def runLoop(self, timestep_ns):
            answer = self._getDataPack("answer")
            assert answer.value in (0.0, 2.5 + 0.10000000149011612), answer.value  # a float has 32 bits
"""
ADD = """
    from nrp_core import *
    from nrp_core.data.nrp_protobuf import *

    @EngineDataPack(keyword="array", id=DataPackIdentifier("array", "one"))
    @TransceiverFunction("one")
    def add(array):
        answer = WrappersDoubleValueDataPack("answer", "one")
        answer.data.value = sum(array.data.array)
        return [answer]
"""


def test_messages_have_the_numbers_of_protocol_buffers(write: Write) -> None:
    path = write(
        {
            "SimulationTimeout": 0.05,
            "EngineConfigs": [python_engine("one", "messages", kind="python_grpc")],
            "DataPackProcessingFunctions": functions("add"),
        },
        messages=MESSAGES, add=ADD,
    )  # fmt: skip
    run(path)


SINK = """
    from nrp_core import *
    from nrp_core.data.nrp_protobuf import DumpArrayFloatDataPack, DumpStringDataPack

    @EngineDataPack(keyword="clock", id=DataPackIdentifier("clock", "one"))
    @TransceiverFunction("sink")
    def write(clock):
        text = DumpStringDataPack("text", "sink")
        text.data.string_stream = str(clock.data["time"])
        matrix = DumpArrayFloatDataPack("matrix", "sink")
        matrix.data.float_stream.extend([1, 2, 3, 4])
        matrix.data.dims.extend([2, 2])
        return [text, matrix]
"""


def test_a_sink_writes_datapacks_to_files(write: Write) -> None:
    sink = {
        "EngineType": "datatransfer_grpc_engine", "EngineName": "sink", "dataDirectory": "data",
        "dumps": [{"name": "text", "file": True}, {"name": "matrix", "file": True}],
    }  # fmt: skip
    path = write(
        {
            "SimulationTimeout": 0.02,
            "EngineConfigs": [python_engine("one", "clock"), sink],
            "DataPackProcessingFunctions": functions("sink"),
        },
        clock=CLOCK, sink=SINK,
    )  # fmt: skip
    run(path)
    data = path.parent / "data" / "0"
    assert (data / "text-0.data").read_text().splitlines() == ["0.000000,0", "0.010000,10000000"]
    first = "0.000000,\n0,1.000000,2.000000\n1,3.000000,4.000000\n"
    assert (data / "matrix-0.data").read_text().startswith(first)


SWING = """
    from nrp_core.engines.py_sim import PySimEngineScript

    class Script(PySimEngineScript):
        def initialize(self):
            self._registerDataPack("state")
            self._setDataPack("state", {"tip": [0, 0, 0]})

        def runLoop(self, timestep_ns):
            self.sim_manager.run_step([1.0], timestep_ns)
            name = self.sim_manager.get_model_properties("site")[0]
            tip = self.sim_manager.get_model_property(name, "site_xpos")
            with open("tip.txt", "a") as file:
                print(self.sim_manager.get_sim_time(), *tip, file=file)
"""
MODEL = """<mujoco><option timestep="0.002"/><worldbody><body><joint name="j" axis="0 1 0" damping="1"/>
<geom type="capsule" fromto="0 0 0 1 0 0" size="0.05" mass="1"/><site name="tip" pos="1 0 0"/></body>
</worldbody><actuator><motor joint="j"/></actuator></mujoco>"""


def test_a_script_drives_mujoco_as_mujoco_alone(write: Write) -> None:
    import mujoco

    engine = {
        **python_engine("arm", "swing", 0.01, "py_sim"),
        "Simulator": "Mujoco",
        "WorldFileName": "arm.xml",
    }
    path = write({"SimulationTimeout": 0.1, "EngineConfigs": [engine]}, swing=SWING)
    path.with_name("arm.xml").write_text(MODEL)
    run(path)
    model = mujoco.MjModel.from_xml_string(MODEL)
    data = mujoco.MjData(model)
    data.ctrl[:] = 1.0
    for line in path.with_name("tip.txt").read_text().splitlines():
        mujoco.mj_step(model, data, 5)
        t, *tip = map(float, line.split())
        assert t == pytest.approx(data.time)
        assert tip == pytest.approx(data.site("tip").xpos.tolist(), abs=1e-12)
