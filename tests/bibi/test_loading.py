"""A BIBI file in the loop: what it declares runs, and what goes wrong names its line."""

from __future__ import annotations

import shutil
from pathlib import Path

import nrp_experiments.braitenberg_husky as experiment
import pytest
from nrp_bibi.loader import load_bibi
from nrp_bibi.model.channels import DeviceType

from nrp_core.cle.loop import Failure
from nrp_core.dsl.functions import TransferFunction
from nrp_core.dsl.testing import Rig
from nrp_core.errors import ExperimentError
from nrp_core.messages.geometry_msgs import Twist, Vector3
from nrp_core.messages.std_msgs import Float64

FOLDER = Path(experiment.__file__).parent
HEAD = '<bibi xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance">\n'
PYTHON = """\
@nrp.MapSpikeSink("d", nrp.brain.p, nrp.population_rate)
@nrp.Neuron2Robot()
def own(t, d):
    return d.rate / 0
"""


def load(folder: Path, inner: str) -> list[TransferFunction]:
    path = folder / "m.bibi"
    path.write_text(f"{HEAD}{inner}\n</bibi>")
    return load_bibi(path)


def place_of(function: TransferFunction) -> str:
    """Where a run that fails is said to have failed."""
    rig = Rig(function)
    with pytest.raises(ZeroDivisionError) as raised:
        rig.run()
    failure = Failure.of(function, raised.value, step=1, t_ns=0)
    return f"{failure.path.name}:{failure.line}"


def test_the_model_of_listing_1_does_what_listing_1_does() -> None:
    (function,) = load_bibi(FOLDER / "listing1.bibi")
    rig = Rig(function)
    rig.set(left_wheel_neuron=0.5, right_wheel_neuron=0.25)
    rig.run()
    assert rig.sent("/husky/cmd_vel") == [Twist(Vector3(5.0, 0, 0), Vector3(0, 0, -25.0))]


def test_an_error_in_generated_code_names_the_line_of_the_model(tmp_path: Path) -> None:
    (function,) = load(
        tmp_path,
        '<transferFunction xsi:type="Neuron2Robot" name="f">\n'
        '  <device name="d" type="PopulationRate">\n'
        '    <neurons population="p"/>\n'
        "  </device>\n"
        '  <local name="a">\n'
        '    <body xsi:type="Divide">\n'
        '      <operand xsi:type="Constant" value="1"/>\n'
        '      <operand xsi:type="ArgumentReference" name="d" property="rate"/>\n'
        "    </body>\n"
        "  </local>\n"
        "</transferFunction>",
    )
    assert place_of(function) == "m.bibi:7"


def test_an_error_in_code_in_place_names_its_own_line(tmp_path: Path) -> None:
    (function,) = load(
        tmp_path, f'<transferFunction xsi:type="PythonTransferFunction">\n\n{PYTHON}</transferFunction>'
    )
    assert place_of(function) == "m.bibi:7"


def test_an_error_in_a_file_names_the_file(tmp_path: Path) -> None:
    (tmp_path / "own.py").write_text(PYTHON)
    (function,) = load(tmp_path, '<transferFunction xsi:type="PythonTransferFunction" src="own.py"/>')
    assert place_of(function) == "own.py:4"


def test_python_beside_the_folder_of_the_model_is_found(tmp_path: Path) -> None:
    (tmp_path / "config").mkdir()
    (tmp_path / "own.py").write_text(PYTHON)
    assert [f.name for f in load(tmp_path / "config", '<transferFunction src="own.py"/>')] == ["own"]


def test_all_python_of_a_model_shares_its_names(tmp_path: Path) -> None:
    helper = "<transferFunctionInline>def gain(x):\n    return 2 * x</transferFunctionInline>\n"
    calls = (
        '<transferFunction xsi:type="Neuron2Robot" name="f">'
        '<local name="x"><body xsi:type="Call" type="gain">'
        '<argument><value xsi:type="Constant" value="4"/></argument></body></local>'
        '<returnValue topic="/x" type="std_msgs.msg.Float64">'
        '<body xsi:type="Call" type="std_msgs.msg.Float64">'
        '<argument><value xsi:type="ArgumentReference" name="x"/></argument></body></returnValue>'
        "</transferFunction>"
    )
    (function,) = load(tmp_path, helper + calls)
    rig = Rig(function)
    rig.run()
    assert [message.data for message in rig.sent("/x")] == [8]


def test_functions_keep_the_order_of_the_model_and_what_it_says_of_them(tmp_path: Path) -> None:
    inline = '<transferFunction xsi:type="PythonTransferFunction" priority="3" active="false">\n'
    block = '<transferFunction xsi:type="Robot2Neuron" name="{}" priority="{}" active="{}"/>\n'
    functions = load(
        tmp_path,
        block.format("a", 2, "true") + f"{inline}{PYTHON}</transferFunction>" + block.format("z", 0, "false"),
    )
    found = [(function.name, function.priority, function.active) for function in functions]
    assert found == [("a", 2, True), ("own", 3, False), ("z", 0, False)]


def test_a_function_runs_when_the_model_says(tmp_path: Path) -> None:
    (function,) = load(
        tmp_path,
        '<transferFunction xsi:type="Robot2Neuron" name="see" throttlingRate="12.5" triggers="odom">'
        '<topic name="odom" topic="/x" type="std_msgs.msg.Float64"/></transferFunction>',
    )
    rig = Rig(function)
    assert not list(function.calls_due(0)), "no message has come"
    rig.set(odom=Float64(1.0))
    due_ms = [t_ms for t_ms in range(0, 200, 20) if list(function.calls_due(t_ms * 10**6))]
    assert due_ms == [0, 80, 160]


@pytest.mark.parametrize(
    ("inner", "message"),
    [
        ("", "declares no transfer function"),
        ("<transferFunctionInline>def f(t:\n  pass</transferFunctionInline>", "m.bibi:2: this is not Python"),
        ("<transferFunctionInline>\nreturn 3</transferFunctionInline>", "m.bibi:3: this is not Python"),
        ('<transferFunction src="onw.py"/>', "m.bibi:2: no file 'onw.py'"),
        (
            '\n<transferFunction xsi:type="Neuron2Robot" name="f"><topic name="x" topic="/x"\n'
            ' type="std_msgs.msg.Flot64"/></transferFunction>', "m.bibi:3: ",
        ),
        (
            '<transferFunction xsi:type="Neuron2Robot" name="f">\n<device name="d" type="Poisson">'
            '<neurons population="p"/></device></transferFunction>',
            "m.bibi:3: parameter 'd': poisson does not read neurons",
        ),
        (
            '<transferFunction xsi:type="Neuron2Robot" name="f"><local name="x">\n<body xsi:type="Call" '
            'type="no_such_module.call"/></local></transferFunction>', "m.bibi:3: ModuleNotFoundError",
        ),
    ],
)  # fmt: skip
def test_a_mistake_is_reported_with_the_line_of_the_model(tmp_path: Path, inner: str, message: str) -> None:
    with pytest.raises(ExperimentError) as refused:
        load(tmp_path, inner)
    assert message in str(refused.value)


def test_two_files_of_one_name_do_not_share_names(tmp_path: Path) -> None:
    for folder in ("a", "b"):
        (tmp_path / folder).mkdir()
        shutil.copy(FOLDER / "listing1.bibi", tmp_path / folder)
    one, two = (load_bibi(tmp_path / folder / "listing1.bibi")[0] for folder in ("a", "b"))
    assert one.function.__globals__ is not two.function.__globals__


DEVICES = {
    "Neuron2Robot": ["LeakyIntegratorAlpha", "LeakyIntegratorExp", "PopulationRate", "SpikeRecorder"],
    "Robot2Neuron": ["ACSource", "DCSource", "FixedFrequency", "NCSource", "Poisson"],
}


@pytest.mark.parametrize(
    ("flow", "kind"), [(flow, kind) for flow, kinds in DEVICES.items() for kind in kinds]
)
def test_every_kind_of_device_runs(tmp_path: Path, flow: str, kind: str) -> None:
    body = '<body xsi:type="Constant" value="0.5"/>' if flow == "Robot2Neuron" else ""
    device = f'<device name="d" type="{kind}"><neurons population="p" from="0" to="4"/>{body}</device>'
    (function,) = load(tmp_path, f'<transferFunction xsi:type="{flow}" name="f">{device}</transferFunction>')
    rig = Rig(function)
    rig.run()
    if body:
        assert (
            getattr(function.d, DeviceType[function.mappings["d"].kind.name.upper()].default_property) == 0.5
        )


@pytest.mark.parametrize("kind", DEVICES["Neuron2Robot"])
def test_every_kind_of_monitor_loads(tmp_path: Path, kind: str) -> None:
    device = f'<device name="d" type="{kind}"><neurons population="p" from="0" to="4"/></device>'
    monitor = f'<transferFunction xsi:type="Neuron2Monitor" name="m">{device}</transferFunction>'
    assert [function.name for function in load(tmp_path, monitor)] == ["m"]
