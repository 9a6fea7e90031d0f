"""A user's file is executed with imports of its own, and leaves no trace of them."""

import sys
from pathlib import Path
from types import CodeType, ModuleType

import pytest
from golden import Golden

from nrp_core.errors import CapabilityError, NetworkError, NrpError
from nrp_core.scripts import Scope

GREETER = ModuleType("robots.greeter")
GREETER.hello = "hello"  # type: ignore[attr-defined]


def scope() -> Scope:
    return Scope(["robots"], {"robots.greeter": GREETER}.get)


def run(folder: Path, source: str, name: str = "script.py") -> ModuleType:
    path = folder / name
    path.write_text(source)
    return scope().run(path)


@pytest.mark.parametrize(
    "source",
    [
        "import robots.greeter\nfound = robots.greeter",
        "import robots.greeter as found",
        "from robots import greeter as found",
        "import robots\nfound = robots.greeter",
        "import importlib\nfound = importlib.import_module('robots.greeter')",
        "from importlib import import_module\nfound = import_module('robots.greeter')",
        "exec('import robots.greeter as found')",
        "def later():\n    import robots.greeter\n    return robots.greeter\nfound = later()",
    ],
)
def test_every_form_of_import_finds_the_substitute(tmp_path: Path, source: str) -> None:
    assert run(tmp_path, source).found is GREETER


def test_names_come_from_the_substitute(tmp_path: Path) -> None:
    assert run(tmp_path, "from robots.greeter import hello").hello == "hello"
    assert run(tmp_path, "from robots.greeter import *").hello == "hello"


def test_submodules_of_a_substitute_are_imported_by_name(tmp_path: Path, golden: Golden) -> None:
    arm = ModuleType("robots.greeter.arm")
    parts = {"robots.greeter": GREETER, "robots.greeter.arm": arm}
    path = tmp_path / "script.py"
    path.write_text("from robots.greeter import arm, hello")
    module = Scope(["robots"], parts.get).run(path)
    assert (module.arm, module.hello) == (arm, "hello")
    path.write_text("from robots.greeter import leg")
    with golden.raises(ImportError, match="'leg'"):
        Scope(["robots"], parts.get).run(path)


def test_other_modules_are_the_real_ones(tmp_path: Path) -> None:
    module = run(tmp_path, "import json, os.path as p\nfrom collections import OrderedDict")
    assert module.json is sys.modules["json"]
    assert module.p is sys.modules["os.path"]


def test_nothing_stays_in_the_list_of_modules(tmp_path: Path) -> None:
    (tmp_path / "neighbour_of_script.py").write_text("import robots.greeter")
    before = set(sys.modules)
    run(tmp_path, "import neighbour_of_script, robots.greeter", "script_without_trace.py")
    assert set(sys.modules) == before


def test_a_file_imports_its_neighbours_once_and_they_see_the_substitutes(tmp_path: Path) -> None:
    (tmp_path / "shared.py").write_text("from robots.greeter import hello\nvalues = []")
    (tmp_path / "other.py").write_text("from shared import values")
    module = run(tmp_path, "import shared, other\nother.values.append(1)")
    assert module.shared.values == [1]
    assert module.shared.hello == "hello"


def test_neighbours_may_import_each_other(tmp_path: Path) -> None:
    (tmp_path / "one.py").write_text("first = 1\nimport two\nboth = first + two.second")
    (tmp_path / "two.py").write_text("import one\nsecond = one.first + 1")
    assert run(tmp_path, "from one import both").both == 3


def test_modules_of_a_package_beside_the_file_import_each_other_relatively(tmp_path: Path) -> None:
    inner = tmp_path / "package" / "inner"
    inner.mkdir(parents=True)
    (inner.parent / "__init__.py").write_text("from .one import values")
    (inner.parent / "one.py").write_text("from robots.greeter import hello\nvalues = [hello]")
    (inner / "__init__.py").touch()
    (inner / "two.py").write_text("from .. import one\nfrom ..one import values\nfrom . import three")
    (inner / "three.py").write_text("import package.one\nsame = package.one.values")
    module = run(tmp_path, "from package.inner import two\nfrom package import values")
    assert module.two.one.values is module.two.values is module.two.three.same is module.values
    assert module.values == ["hello"]


def test_a_neighbour_that_fails_fails_again(tmp_path: Path) -> None:
    (tmp_path / "broken.py").write_text("1 / 0")
    source = "try:\n    import broken\nexcept ZeroDivisionError:\n    import broken"
    with pytest.raises(ZeroDivisionError):
        run(tmp_path, source)


def test_two_runs_of_one_file_share_nothing(tmp_path: Path) -> None:
    (tmp_path / "counter.py").write_text("count = []")
    source = "import counter\ncounter.count.append(1)"
    first, second = run(tmp_path, source), run(tmp_path, source)
    assert first is not second
    assert second.counter.count == [1]


def test_dataclasses_with_annotations_as_text_work(tmp_path: Path) -> None:
    source = (
        "from __future__ import annotations\nfrom dataclasses import dataclass\n"
        "@dataclass\nclass Cell:\n    tau: float\n"
    )
    assert run(tmp_path, source).Cell(2.0).tau == 2.0


def raised(folder: Path, source: str) -> NrpError:
    path = folder / "script.py"
    path.write_text(source)
    own = scope()
    with pytest.raises(Exception) as caught:  # noqa: PT011
        own.run(path)
    return own.located(caught.value, NetworkError, path)


def test_an_error_is_placed_at_the_line_of_the_file_and_not_of_the_library(tmp_path: Path) -> None:
    error = raised(tmp_path, "import json\n\njson.loads('{')\n")
    assert isinstance(error, NetworkError)
    assert (error.path, error.line) == (tmp_path / "script.py", 3)
    assert error.message.startswith("JSONDecodeError: ")


def test_an_error_in_a_neighbour_is_placed_there(tmp_path: Path, golden: Golden) -> None:
    (tmp_path / "helper.py").write_text("\n1 / 0\n")
    error = raised(tmp_path, "import helper")
    golden(str(error))


def test_a_syntax_error_has_its_line_and_column(tmp_path: Path, golden: Golden) -> None:
    error = raised(tmp_path, "a = 1\nb = = 2\n")
    assert isinstance(error, NetworkError)
    assert (error.line, error.column) == (2, 5)
    golden(error.message)


def test_errors_of_the_platform_keep_their_class_and_gain_a_place(tmp_path: Path, golden: Golden) -> None:
    source = "from nrp_core.errors import CapabilityError\nraise CapabilityError('there is none')"
    error = raised(tmp_path, source)
    assert isinstance(error, CapabilityError)
    golden(str(error))


def test_a_place_that_is_known_stays(tmp_path: Path) -> None:
    source = "from nrp_core.errors import NetworkError\nraise NetworkError('bad', path='net.h5', line=9)"
    assert str(raised(tmp_path, source)) == "net.h5:9: bad"


def test_an_error_from_elsewhere_has_no_place() -> None:
    assert scope().place_of(ValueError("elsewhere")) is None


def test_modules_in_folders_are_packages_for_files_of_the_scope(tmp_path: Path) -> None:
    package = tmp_path / "elsewhere" / "tools"
    package.mkdir(parents=True)
    (package / "__init__.py").write_text("")
    (package / "deep.py").write_text("import plain\nvalue = plain.value + 1\n")
    (tmp_path / "plain.py").write_text("value = 1\n")
    path = tmp_path / "script.py"
    path.write_text(
        "import tools.deep\nfrom tools import deep\nfrom tools.deep import value\nfound = tools.deep is deep"
    )
    module = Scope([], {}.get, [tmp_path / "elsewhere"]).run(path)
    assert (module.found, module.value) == (True, 2)
    assert "tools" not in sys.modules


def test_a_stand_in_for_a_missing_module_serves_only_that_module(tmp_path: Path, golden: Golden) -> None:
    made = {name: ModuleType(name) for name in ("nowhere", "nowhere.part")}
    made["nowhere"].part = made["nowhere.part"]  # type: ignore[attr-defined]
    asked = []

    def missing(name: str, importer: object) -> ModuleType | None:
        asked.append(name)
        return made.get(name)

    path = tmp_path / "script.py"
    path.write_text(
        "import nowhere.part\nfrom nowhere import part\nfound = part is nowhere.part\nimport json"
    )
    assert Scope([], {}.get, missing=missing).run(path).found
    assert set(asked) == {"nowhere", "nowhere.part"}
    path.write_text("import elsewhere")
    with golden.raises(ModuleNotFoundError):
        Scope([], {}.get, missing=missing).run(path)


def test_files_can_be_compiled_otherwise_and_those_they_import_too(tmp_path: Path) -> None:
    (tmp_path / "helper.py").write_text("value = <1>\n")
    path = tmp_path / "script.py"
    path.write_text("import helper\nvalue = helper.value + <2>\n")

    def compiled(file: Path) -> CodeType:
        return compile(file.read_text().replace("<", "").replace(">", ""), str(file), "exec")

    assert Scope([], {}.get, compiled=compiled).run(path).value == 3
