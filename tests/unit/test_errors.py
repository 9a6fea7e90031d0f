"""Errors are ours and the matching builtin, and say where."""

import inspect

import pytest

from nrp_core import errors
from nrp_core.errors import ExperimentError, NrpError, did_you_mean

ALL = [c for _, c in inspect.getmembers(errors, inspect.isclass) if issubclass(c, NrpError)]


@pytest.mark.parametrize("cls", ALL)
def test_every_error_is_drawn_in_the_module_and_derives_from_the_base(cls: type[NrpError]) -> None:
    assert cls.__name__ in (errors.__doc__ or "")


@pytest.mark.parametrize("cls", [c for c in ALL if c not in (NrpError, errors.BackendError)])
def test_every_error_that_is_raised_is_also_a_builtin(cls: type[NrpError]) -> None:
    builtins = {ValueError, LookupError, ImportError, RuntimeError, NotImplementedError, ArithmeticError}
    assert builtins & set(cls.__mro__)


def test_a_location_holds_its_known_parts() -> None:
    assert str(ExperimentError("bad", path="a.yaml", line=3, column=7)) == "a.yaml:3:7: bad"
    assert str(ExperimentError("bad", path="a.yaml", line=3)) == "a.yaml:3: bad"
    assert str(ExperimentError("bad")) == "bad"


def test_a_misspelt_name_gets_the_nearest_one_and_a_strange_one_gets_them_all() -> None:
    assert did_you_mean("mujco", ["mujoco", "pybullet"]) == "; did you mean 'mujoco'?"
    assert did_you_mean("xyz", ["mujoco", "pybullet"]) == "; valid: mujoco, pybullet"
    assert did_you_mean("xyz", []) == "; there are none"
    assert did_you_mean("xyz", ["b", "a", "b"]) == "; valid: a, b"


def test_of_very_many_names_the_most_similar_ones_are_suggested() -> None:
    hint = did_you_mean("/lamp/color", ["/lamp/body/glass/off", *(f"/gazebo/service_{i}" for i in range(40))])
    listed = hint.removeprefix("; valid: ").partition(" and ")[0].split(", ")
    assert "/lamp/body/glass/off" in listed
    assert listed == sorted(listed)
    assert hint.endswith(" and 35 more")
