"""What configurations are refused for, and where."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from configurations import Write, functions, python_engine

from nrp_core import Code, InvalidExperimentError, Run, load_experiment, validate
from nrp_core.errors import ExperimentError
from nrp_core.experiment import find_file

ENGINE = "from nrp_core.engines.python_json import EngineScript\nclass Script(EngineScript):\n    pass\n"
ONE = python_engine("one", "engine")


@pytest.mark.parametrize(
    ("change", "code", "line"),
    [
        ({"SimulationLoop": "EventLop"}, Code.NRP216, 3),
        ({"DataPackProcessor": "graph"}, Code.NRP216, 3),
        ({"DataPackProcessor": "cg", "ComputationalGraph": ["none.py"]}, Code.NRP204, 5),
        ({"EngineConfigs": [{**ONE, "EngineType": "edlut_grpc_engine"}]}, Code.NRP216, 5),
        ({"EngineConfigs": [{**ONE, "EngineType": "python_jsn"}]}, Code.NRP216, 5),
        ({"EngineConfigs": [{**ONE, "Simulator": "Webots"}]}, Code.NRP216, 8),
        ({"EngineConfigs": [ONE, ONE]}, Code.NRP202, 11),
        ({"EngineConfigs": [{**ONE, "PythonFileName": "other.py"}]}, Code.NRP204, 7),
        ({"EngineConfigs": [{**ONE, "EngineTimestep": -1}]}, Code.NRP202, 8),
        ({"DataPackProcessingFunctions": functions("missing")}, Code.NRP204, 6),
    ],
)
def test_mistakes_are_named_with_their_line(
    write: Write, change: dict[str, Any], code: Code, line: int
) -> None:
    path = write({"SimulationTimeout": 1, **change, "EngineConfigs": [ONE], **change}, engine=ENGINE)
    with pytest.raises(InvalidExperimentError) as caught:
        load_experiment(path)
    found = [(one.code, one.line) for one in caught.value.findings]
    assert found == [(code, line)]


def test_text_that_is_not_json_is_reported_with_its_line(write: Write) -> None:
    path = write({"EngineConfigs": []})
    path.write_text('{\n"EngineConfigs": [,]\n}')
    with pytest.raises(InvalidExperimentError) as caught:
        load_experiment(path)
    assert [(one.code, one.line) for one in caught.value.findings] == [(Code.NRP200, 2)]


WRONG = """
    from nrp_core import *

    @EngineDataPack(keyword="state", id=DataPackIdentifier("state", "two"))
    @TransceiverFunction("one")
    def wrong(state):
        return []
"""


def test_functions_name_engines_that_exist(write: Write) -> None:
    config = {
        "SimulationTimeout": 1,
        "EngineConfigs": [ONE],
        "DataPackProcessingFunctions": functions("wrong"),
    }
    path = write(config, engine=ENGINE, wrong=WRONG)
    with pytest.raises(InvalidExperimentError) as caught:
        Run(load_experiment(path))
    assert [one.code for one in caught.value.findings] == [Code.NRP210]


WRONG_NODE = """
    from nrp_core.event_loop import *

    @ToEngine(keyword="out", address="/two")
    @FunctionalNode(name="node", outputs=["out"])
    def node():
        return [None]
"""


def test_nodes_send_to_engines_that_exist(write: Write) -> None:
    config = {
        "SimulationTimeout": 1,
        "DataPackProcessor": "cg",
        "EngineConfigs": [ONE],
        "ComputationalGraph": ["node.py"],
    }
    path = write(config, engine=ENGINE, node=WRONG_NODE)
    with pytest.raises(InvalidExperimentError) as caught:
        Run(load_experiment(path))
    assert [one.code for one in caught.value.findings] == [Code.NRP210]


@pytest.mark.parametrize("text", ["from nrp_core import Run\n", "import nrp_core.brain\n"])
def test_files_do_not_see_this_program(write: Write, text: str) -> None:
    path = write({"SimulationTimeout": 1, "EngineConfigs": [ONE]}, engine=text + ENGINE)
    with pytest.raises(Exception, match=r"engine\.py:1"):
        Run(load_experiment(path))


def test_of_a_correct_experiment_only_its_functions_are_not_checked(write: Write) -> None:
    path = write({"SimulationTimeout": 1, "EngineConfigs": [ONE]}, engine=ENGINE)
    assert [finding.code for finding in validate(path)] == [Code.NRP239]


def test_a_folder_is_found_by_its_configuration_among_other_json_files(write: Write) -> None:
    path = write({"SimulationTimeout": 1, "EngineConfigs": [ONE]}, engine=ENGINE)
    path.with_name("package.json").write_text("{}")
    assert find_file(str(path.parent)) == path
    path.with_name("second.json").write_text(path.read_text())
    with pytest.raises(ExperimentError, match=r"second\.json"):
        find_file(str(path.parent))


def test_a_json_file_of_another_kind_is_refused(tmp_path: Path) -> None:
    (tmp_path / "package.json").write_text("{}")
    with pytest.raises(InvalidExperimentError):
        load_experiment(tmp_path / "package.json")
