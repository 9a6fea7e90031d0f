"""Files of transfer functions are executed each in a world of its own."""

from __future__ import annotations

import importlib.metadata
import sys
import threading
from collections.abc import Callable
from pathlib import Path
from types import ModuleType

import pytest
from golden import Golden

import nrp_core.dsl as nrp
from nrp_core.dsl.functions import TransferFunction, collecting
from nrp_core.dsl.loading import file_scope, load_transfer_functions, python_listing
from nrp_core.dsl.testing import Rig
from nrp_core.errors import ExperimentError, NrpError, TransferFunctionError

Load = Callable[[str], list[TransferFunction]]


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("x = 1\ndef f(t:\n    pass\n", 2),
        ("def f(t):\n\tpass\n        pass\n", 3),
        ("x = 1\n\ny = 1 / 0\n", 3),
        ("def g():\n    return undefined\n\ng()\n", 2),
        ("from geometry_msgs.msg import Twits\n", 1),
        ("import no_such_module\n", 1),
        ("raise SystemExit(3)\n", 1),
        ("nrp.brain.sensors[0]\n", 1),
        ("x = '\0'\n", None),
    ],
)
def test_a_mistake_in_a_file_is_reported_with_its_line(
    load: Load, text: str, line: int | None, golden: Golden
) -> None:
    with golden.raises(TransferFunctionError) as caught:
        load(text)
    assert Path(str(caught.value.path)).name == "functions.py"
    assert caught.value.line == line


def test_a_package_of_messages_has_no_services(load: Load) -> None:
    with pytest.raises(TransferFunctionError, match="'geometry_msgs") as caught:  # imported elsewhere, or not
        load("import geometry_msgs.srv\n")
    assert caught.value.line == 1


def test_a_missing_file_is_reported_with_similar_names(tmp_path: Path, golden: Golden) -> None:
    with pytest.raises(TransferFunctionError) as caught:
        load_transfer_functions(tmp_path / "listing.py")
    golden(caught.value.message)
    (tmp_path / "listing1.py").write_text("")
    with golden.raises(TransferFunctionError, match=r"'listing1\.py'"):
        load_transfer_functions(tmp_path / "listing.py")


def test_an_error_with_a_place_of_its_own_keeps_it(load: Load) -> None:
    with pytest.raises(ExperimentError) as caught:
        load("x = 1\n\n@nrp.MapVariable('y')\n@nrp.Robot2Neuron()\ndef f(t): pass\n")
    assert caught.value.line == 3


def test_an_error_of_ours_without_a_place_gets_one(load: Load, golden: Golden) -> None:
    with golden.raises(NrpError):
        load("from nrp_core.errors import TopicError\nraise TopicError('no topic')\n")


@pytest.mark.parametrize(
    "imports",
    [
        "import geometry_msgs.msg\nT = geometry_msgs.msg.Twist",
        "import geometry_msgs.msg as gm\nT = gm.Twist",
        "from geometry_msgs import msg\nT = msg.Twist",
        "from geometry_msgs.msg import Twist as T",
        "from geometry_msgs.msg import *\nT = Twist",
        "T = geometry_msgs.msg.Twist",
    ],
)
def test_messages_are_found_however_they_are_imported_and_are_ours(load: Load, imports: str) -> None:
    before = set(sys.modules)
    (function,) = load(f"{imports}\n@nrp.Neuron2Robot(Topic('/cmd', T))\ndef f(t): pass")
    assert function.topic is not None
    assert function.topic.topic_type.__module__ == "nrp_core.messages.geometry_msgs"
    assert not {name for name in set(sys.modules) - before if name.startswith("geometry_msgs")}


def test_messages_are_ours_even_where_others_are_installed(
    load: Load, monkeypatch: pytest.MonkeyPatch
) -> None:
    foreign, messages = ModuleType("geometry_msgs"), ModuleType("geometry_msgs.msg")
    messages.Twist = foreign.msg = messages  # type: ignore[attr-defined]
    monkeypatch.setitem(sys.modules, "geometry_msgs", foreign)
    monkeypatch.setitem(sys.modules, "geometry_msgs.msg", messages)
    (function,) = load(
        """
        import geometry_msgs.msg
        @nrp.Neuron2Robot(Topic("/cmd", geometry_msgs.msg.Twist))
        def f(t):
            from geometry_msgs.msg import Twist
            return Twist()
        """
    )
    Rig(function).run()
    assert sys.modules["geometry_msgs"] is foreign


def test_other_imports_work_as_ever(load: Load) -> None:
    (function,) = load(
        "import math, os.path\nfrom collections import deque\n@nrp.Robot2Neuron()\n"
        "def f(t): return math.pi, os.path.sep, deque"
    )
    assert function(0)[0] > 3


def test_further_modules_can_be_lent_to_a_file(tmp_path: Path) -> None:
    path = tmp_path / "functions.py"
    path.write_text("from lent.numbers import answer\n@nrp.Robot2Neuron()\ndef f(t): return answer\n")
    lent = ModuleType("lent.numbers")
    lent.answer = 42  # type: ignore[attr-defined]
    assert load_transfer_functions(path, scope=file_scope(nrp, {"lent.numbers": lent}))[0](0) == 42
    assert "lent" not in sys.modules


def test_a_file_may_import_its_neighbour(load: Load, tmp_path: Path) -> None:
    (tmp_path / "gains.py").write_text("from std_msgs.msg import Float64\nGAIN = Float64(7.0)\n")
    (function,) = load("from gains import GAIN\n@nrp.Robot2Neuron()\ndef f(t): return GAIN.data")
    assert function(0) == 7.0
    assert "gains" not in sys.modules


def test_files_do_not_see_each_other_unless_they_share_a_module(tmp_path: Path, golden: Golden) -> None:
    first, second = tmp_path / "first.py", tmp_path / "second.py"
    first.write_text("shared = 5\n@nrp.Robot2Neuron()\ndef f(t): return 1\n")
    second.write_text("x = shared\n@nrp.Robot2Neuron()\ndef g(t): return f(t) + x\n")
    load_transfer_functions(first)
    with golden.raises(TransferFunctionError, match="'shared'"):
        load_transfer_functions(second)
    module = ModuleType("experiment")
    load_transfer_functions(first, module=module)
    (function,) = load_transfer_functions(second, module=module)
    assert function(0) == 6


def test_changes_that_a_file_makes_to_the_library_stay_in_that_file(load: Load) -> None:
    text = """
        @nrp.Robot2Neuron()
        def f(t):
            nrp.tf_lib.cam.set_image_size(640, 480)
            return nrp.tf_lib.cam
        """
    (function,), (other,) = load(text), load(text)
    changed = function(0)
    assert changed.width == 640
    assert nrp.tf_lib.cam.width == 320
    assert other(0) is not changed


def test_a_file_finds_everything_that_the_language_has(load: Load) -> None:
    (function,) = load(
        """
        import hbp_nrp_client.tf_framework as framework

        @nrp.Robot2Neuron()
        def f(t):
            return framework, nrp
        """
    )
    framework, given = function(0)
    assert framework is given
    assert set(nrp.__all__) <= set(vars(framework))


def test_functions_register_only_with_the_loader_that_reads_them() -> None:
    @nrp.Robot2Neuron()
    def outside(t: float) -> None: ...

    with collecting() as first:

        @nrp.Robot2Neuron()
        def one(t: float) -> None: ...

        with collecting() as second:

            @nrp.Robot2Neuron()
            def two(t: float) -> None: ...

    assert (first, second) == ([one], [two])


def test_threads_that_load_at_once_do_not_meet(tmp_path: Path) -> None:
    """Each file waits in its middle until all threads are there."""
    barrier = threading.Barrier(4)
    gate = ModuleType("gate")
    gate.wait = lambda: barrier.wait(timeout=60)  # type: ignore[attr-defined]
    loaded: dict[int, list[str]] = {}

    def load(i: int) -> None:
        path = tmp_path / f"f{i}.py"
        path.write_text(
            f"import gate\n@nrp.Robot2Neuron()\ndef before_{i}(t): pass\ngate.wait()\n"
            f"@nrp.Robot2Neuron()\ndef after_{i}(t): pass\n"
        )
        loaded[i] = [
            function.name for function in load_transfer_functions(path, scope=file_scope(nrp, {"gate": gate}))
        ]

    threads = [threading.Thread(target=load, args=(i,)) for i in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert loaded == {i: [f"before_{i}", f"after_{i}"] for i in range(4)}


def test_the_loader_is_found_by_the_suffix_of_the_file() -> None:
    (entry,) = importlib.metadata.entry_points(group="nrp_core.transfer_functions", name=".py")
    assert entry.load() is load_transfer_functions


@pytest.mark.parametrize("read", [load_transfer_functions, python_listing])
@pytest.mark.parametrize(
    ("data", "line", "column", "message"),
    [
        (
            "x = 1\ny = 'caf\u00e9'\n".encode("latin-1"),
            2,
            9,
            "UTF-8.*0xe9, 'é'.*Latin-1",
        ),
        ("x = 1\n".encode("utf-16"), 1, 1, "UTF-8.*0xff"),
        (b"# coding: no-such\nx = 1\n", 1, 1, ""),
        (b"# coding: ascii\n\ny = '\xc3\xa9'\n", 3, 6, "0xc3"),
    ],
)
def test_a_file_in_another_encoding_is_reported_with_the_place_of_the_first_wrong_byte(
    tmp_path: Path,
    read: Callable[[Path], object],
    data: bytes,
    line: int,
    column: int,
    message: str,
    golden: Golden,
) -> None:
    path = tmp_path / "functions.py"
    path.write_bytes(data)
    with golden.raises(TransferFunctionError, match=message) as caught:
        read(path)
    assert (caught.value.line, caught.value.column) == (line, column)
