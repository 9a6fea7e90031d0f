"""Client scripts: states, iterations, trajectories, datapacks of the client, resets."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from configurations import Write, functions, python_engine
from golden import Golden
from google.protobuf.wrappers_pb2 import StringValue
from nrp_client import NrpCore

ENGINE = """
    from nrp_core.engines.python_json import EngineScript

    class Script(EngineScript):
        def initialize(self):
            self._registerDataPack("action")
            self._registerDataPack("state")
            self._setDataPack("state", {"time": self._time_ns, "value": 0})

        def runLoop(self, timestep_ns):
            action = self._getDataPack("action") or {}
            self._setDataPack("state", {"time": self._time_ns, "value": action.get("value", 0)})

        def reset(self):
            action = self._getDataPack("action") or {}
            self._setDataPack("state", {"time": self._time_ns, "value": action.get("value", 0)})
"""
RELAY = """
    from nrp_core import *

    @EngineDataPack(keyword="one", id=DataPackIdentifier("state", "one"))
    @EngineDataPack(keyword="two", id=DataPackIdentifier("state", "two"))
    @TransceiverFunction("two")
    def relay(one, two):
        return []
"""
STATUS = """
    from nrp_core import *
    from nrp_core.data.nrp_json import JsonRawData
    from nrp_core.data.nrp_protobuf import EngineTestTestPayloadRawData

    @EngineDataPack(keyword="one", id=DataPackIdentifier("state", "one"))
    @EngineDataPack(keyword="two", id=DataPackIdentifier("state", "two"))
    @SimulationIteration(keyword="n")
    @StatusFunction()
    def status(one, two, n):
        seen = JsonRawData()
        seen.data["value"] = one.data["value"]
        seen.data["new"] = two.isUpdated()
        number = EngineTestTestPayloadRawData()
        number.data.integer = n
        return {done}, [seen, number]
"""


@pytest.fixture
def client(write: Write, request: pytest.FixtureRequest) -> Iterator[NrpCore]:
    """Return a client of two engines, 10 and 20 ms; the parameter is when it is done."""
    done = getattr(request, "param", None)
    config = {
        "SimulationTimeout": 0.1,
        "EngineConfigs": [python_engine("one", "engine", 0.01), python_engine("two", "engine", 0.02)],
        "DataPackProcessingFunctions": functions("relay"),
    }
    if done is not None:
        config["StatusFunction"] = {"Name": "status", "FileName": "status.py"}
    path = write(config, engine=ENGINE, relay=RELAY, status=STATUS.replace("{done}", str(done)))
    nrp = NrpCore("localhost:50050", str(path.parent))
    yield nrp
    if nrp.current_state() != "Created":
        nrp.shutdown()


def test_states_follow_the_calls(client: NrpCore) -> None:
    states = [client.current_state()]
    calls = (client.initialize, lambda: client.run_loop(4), client.reset, client.run_until_timeout)
    for call in (*calls, client.shutdown):
        call()
        states.append(client.current_state())
    assert states == ["Created", "Initialized", "Stopped", "Initialized", "Stopped", "Created"]


def test_calls_out_of_order_are_refused(client: NrpCore) -> None:
    for call in (lambda: client.run_loop(1), client.shutdown):
        with pytest.raises(ConnectionError):
            call()
    client.initialize()
    with pytest.raises(ConnectionError):
        client.initialize()


def test_initialize_and_reset_return_the_requested_datapacks(client: NrpCore) -> None:
    assert [one["time"] for one in client.initialize()] == [0, 0]
    client.run_loop(2)
    client.set_json_datapack("action", "one", {"value": 987})
    # reset() of a script runs before its clock is 0; the datapack of the client goes to the first engine
    assert client.reset() == [{"time": 20_000_000, "value": 987}, {"time": 20_000_000, "value": 0}]


def test_without_a_status_function_the_time_ends_the_run(client: NrpCore) -> None:
    client.initialize()
    assert client.run_until_timeout() == (False, True, [])
    assert client.run_until_timeout() == (False, True, [])


@pytest.mark.parametrize("client", ["True"], indirect=True)
def test_a_datapack_of_the_client_is_seen_a_step_later(client: NrpCore) -> None:
    client.initialize()
    client.set_json_datapack("action", "one", {"value": 888})
    seen = [client.run_loop(1) for _ in range(3)]
    assert [done for done, _ in seen] == [True] * 3
    assert [trajectory[0]["value"] for _, trajectory in seen] == [0, 888, 888]
    assert [trajectory[0]["new"] for _, trajectory in seen] == [True, False, True]


@pytest.mark.parametrize("client", ["n == 3"], indirect=True)
def test_the_trajectory_is_delivered_when_the_run_is_done(client: NrpCore) -> None:
    client.initialize()
    assert client.run_loop(2) == (False, [])
    done, timeout, trajectory = client.run_until_timeout()
    assert (done, timeout) == (True, False)
    assert [one.integer for one in trajectory[1::2]] == [0, 1, 2, 3]


@pytest.mark.parametrize("client", ["two.isUpdated()"], indirect=True)
def test_done_is_that_of_the_last_call(client: NrpCore) -> None:
    client.initialize()
    assert [client.run_loop(1)[0] for _ in range(4)] == [True, False, True, False]


def test_an_asynchronous_call_appends_its_reply(client: NrpCore) -> None:
    client.initialize()
    response: list[object] = []
    client.run_loop(3, run_async=True, response=response).join()
    assert client.unpack_thread_results(response[0]) == (False, [])  # type: ignore[arg-type]


@pytest.mark.parametrize("client", ["1 / 0"], indirect=True)
def test_an_error_in_a_function_fails_the_run_with_its_line(client: NrpCore, golden: Golden) -> None:
    client.initialize()
    with golden.raises(RuntimeError):
        client.run_loop(1)
    assert client.current_state() == "Failed"


def test_a_missing_configuration_is_reported_at_once(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError):
        NrpCore("localhost:50050", str(tmp_path))


def test_a_client_script_runs_by_the_command(write: Write, tmp_path: Path) -> None:
    config = {"SimulationTimeout": 0.1, "EngineConfigs": [python_engine("one", "engine")]}
    path = write(config, engine=ENGINE)
    script = tmp_path / "client.py"
    script.write_text(
        "from nrp_client import NrpCore\n"
        f"nrp = NrpCore('localhost:1', experiment_folder={str(path.parent)!r})\n"
        "nrp.initialize()\nprint(nrp.run_until_timeout())\nnrp.shutdown()\n"
    )
    done = subprocess.run(
        [sys.executable, "-m", "nrp_client", script], capture_output=True, text=True, check=True
    )
    assert done.stdout.strip() == "(False, True, [])"


def test_datapacks_wait_in_the_buffers_that_scripts_read(client: NrpCore) -> None:
    """One for an unknown engine is dropped by the server, and an address needs a port."""
    client.initialize()
    for send in (lambda: client.run_loop(1), client.reset):
        client.set_json_datapack("action", "one", {"value": 3})
        client.set_proto_datapack("action", "nobody", StringValue())
        assert len(client._json_datapack_out_buffer) == len(client._proto_datapack_out_buffer) == 1
        send()
        assert not client._json_datapack_out_buffer + client._proto_datapack_out_buffer
    with pytest.raises(ConnectionError):
        NrpCore("somewhere")
