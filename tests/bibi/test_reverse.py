"""From Python to models and back."""

from __future__ import annotations

import ast
from pathlib import Path

import nrp_experiments.braitenberg_husky as experiment
import pytest
from golden import Golden
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.strategies import SearchStrategy
from nrp_bibi import Bibi, bibi_text, generate, parse_bibi, read_bibi
from nrp_bibi.model.functions import Neuron2Robot, PythonTransferFunction, Robot2Neuron
from nrp_bibi.reverse import reverse, reverse_file

from nrp_core.errors import ExperimentError

FOLDER = Path(experiment.__file__).parent
PATH = Path("model.bibi")


@given(data=st.data())
@settings(deadline=None, max_examples=8)
def test_generated_code_of_a_model_generates_the_same_model(
    models: SearchStrategy[Bibi], data: st.DataObject
) -> None:
    model = data.draw(models)
    code = generate(model, PATH)
    again = reverse(code, Path("made.py"))
    assert generate(again, PATH) == code
    assert not any(isinstance(one, PythonTransferFunction) for one in again.transfer_function)
    assert reverse(generate(again, PATH), PATH) == again == parse_bibi(bibi_text(again))


@pytest.mark.parametrize("name", ["listing1", "listing2"])
def test_the_listings_become_their_models(name: str) -> None:
    assert reverse_file(FOLDER / f"{name}.py") == read_bibi(FOLDER / f"{name}.bibi")


def test_both_spellings_of_a_selector_are_understood() -> None:
    kinds = [type(one) for one in reverse_file(FOLDER / "nrp_gains.py").transfer_function]
    assert kinds == [PythonTransferFunction, Robot2Neuron, PythonTransferFunction]


HEAD = '@nrp.MapSpikeSink("d", nrp.brain.p[0], nrp.population_rate)\n'


@pytest.mark.parametrize(
    "code",
    [
        f"{HEAD}@nrp.Neuron2Robot()\ndef f(t, d):\n    if d.rate > 3:\n        print(t)",
        f"{HEAD}@nrp.Neuron2Robot()\ndef f(t, d):\n    x = d.rate**2",
        f"{HEAD}@nrp.Neuron2Robot(throttling_rate=-3.0)\ndef f(t, d):\n    x = d.rate",
        f"{HEAD}@nrp.Neuron2Robot(throttling_rate=True)\ndef f(t, d):\n    x = d.rate",
        f"{HEAD}@nrp.Neuron2Robot(priority=-1)\ndef f(t, d):\n    x = d.rate",
        f'{HEAD}@nrp.Neuron2Robot(triggers="d")\ndef f(t, d):\n    x = d.rate',
        f'{HEAD}@nrp.Neuron2Robot(triggers=["t"])\ndef f(t, d):\n    x = d.rate',
        f"{HEAD}@nrp.Neuron2Robot(triggers=[])\ndef f(t, d):\n    x = d.rate",
        f"{HEAD}@nrp.Neuron2Robot(triggers=3)\ndef f(t, d):\n    x = d.rate",
        f'{HEAD}@nrp.Neuron2Robot()\ndef f(t, d):\n    """A docstring."""\n    x = 1',
        f"{HEAD}@nrp.Neuron2Robot()\ndef f(t, d):\n    x = unknown + 1",
        f"{HEAD}@nrp.Neuron2Robot()\ndef f(t, d=3):\n    x = 1",
        '@nrp.MapVariable("d", initial_value=3)\n@nrp.Neuron2Robot()\ndef f(t, d):\n    x = d.value',
        '@nrp.MapSpikeSource("d", nrp.brain.p[0], nrp.poisson)\n'
        "@nrp.Robot2Neuron()\ndef f(t, d):\n    d.active = 1",
        "import numpy as np",
        "def helper(x):\n    return x",
        "f.active = False",
    ],
)  # fmt: skip
def test_code_that_building_blocks_cannot_express_is_kept_as_written(code: str) -> None:
    model = reverse(f"import hbp_nrp_client.tf_framework as nrp\n\n{code}\n", Path("f.py"))
    assert model.transfer_function == (PythonTransferFunction(code=code),)
    assert ast.dump(ast.parse(generate(model, PATH, with_imports=False))) == ast.dump(ast.parse(code))


@pytest.mark.parametrize("triggers", ['"camera"', '("camera",)', '["camera"]'])
def test_every_spelling_of_when_a_function_runs_is_understood(triggers: str) -> None:
    code = (
        '@nrp.MapRobotSubscriber("camera", Topic("/husky/camera", sensor_msgs.msg.Image))\n'
        f"@nrp.Robot2Neuron(throttling_rate=12.5, triggers={triggers})\ndef f(t, camera):\n    pass\n"
    )
    (function,) = reverse(code, Path("f.py")).transfer_function
    assert isinstance(function, Robot2Neuron)
    assert (function.trigger, function.throttling_rate) == (("camera",), 12.5)


def test_code_that_is_not_python_is_refused_with_its_line(tmp_path: Path, golden: Golden) -> None:
    broken = tmp_path / "f.py"
    broken.write_text("x = 1\ndef f(:\n")
    with golden.raises(ExperimentError, match=r"f\.py:2"):
        reverse_file(broken)


IMPORTING = """\
import hbp_nrp_client.tf_framework as nrp
import numpy as np
from geometry_msgs.msg import Twist, Vector3 as Vector
from std_msgs.msg import Float64


@nrp.MapSpikeSink("left", nrp.brain.actors[0], nrp.leaky_integrator_alpha)
@nrp.MapRobotPublisher("told", nrp.Topic("/told", Float64))
@nrp.Neuron2Robot(nrp.Topic("/husky/cmd_vel", Twist))
def drive(t, left, told):
    fast = np.sqrt(left.voltage)
    told.send_message(Float64(fast))
    return Twist(Vector(20.0 * fast), Vector(z=t))
"""


def test_imported_names_and_any_order_of_mappings_are_understood() -> None:
    model = reverse(IMPORTING, Path("m.py"))
    (function,) = model.transfer_function
    assert isinstance(function, Neuron2Robot)
    python = generate(model, Path("m.bibi"))
    assert "import numpy\n" in python
    assert "def drive(t, told, left):" in python
    assert "return geometry_msgs.msg.Twist(" in python


def test_code_that_is_kept_as_python_keeps_its_imports() -> None:
    own = "\n\n@nrp.Robot2Neuron()\ndef own(t):\n    print(Vector(t))\n"
    functions = reverse(IMPORTING + own, Path("m.py")).transfer_function
    kept = [one.code for one in functions if isinstance(one, PythonTransferFunction)]
    assert kept == ["from geometry_msgs.msg import Twist, Vector3 as Vector", own.strip()]


def test_a_name_that_hides_an_import_is_not_written_out() -> None:
    hidden = IMPORTING.replace("(t, left, told)", "(t, np, told)").replace('"left"', '"np"')
    (function,) = reverse(hidden.replace("left.voltage", "np.voltage"), Path("m.py")).transfer_function
    assert isinstance(function, PythonTransferFunction)
