"""What the public functions say to an argument of the wrong kind, and that they take all that is right."""

from __future__ import annotations

import importlib
import inspect
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from typing import Any, Literal, Protocol

import numpy as np
import numpy.typing as npt
import pandas as pd
import pytest
from golden import Golden
from nrp_lab.comparison import Margin

import nrp_core
from nrp_core._support.arrays import FloatArray
from nrp_core._support.checked_arguments import admits, checks_arguments, in_words, require_fields
from nrp_core.errors import ArgumentError, NeuronSelectionError, SceneError

DOORS = ("nrp_core", "nrp_lab.sweep", "nrp_lab.evolve")
WITH_ADVICE = {
    "run": "overrides images snapshots_s on_step until_s",
    "open_run": "overrides",
    "open_world": "overrides",
    "load_experiment": "text overrides",
    "validate": "experiment",
    "load_network": "seed",
    "save_nir": "method",
    "sweep": "description workers",
    "evolve": "description workers",
}
"""Arguments that functions check themselves, with better advice; their tests are with the functions."""


def public_arguments() -> Iterator[tuple[Callable[..., Any], str]]:
    for door in DOORS:
        module = importlib.import_module(door)
        functions = (getattr(module, name) for name in module.__all__)
        for function in functions:
            if inspect.isfunction(function):
                own = WITH_ADVICE.get(function.__name__, "").split()
                for name in inspect.signature(function).parameters:
                    if name not in own:
                        yield function, name


@pytest.mark.parametrize(
    ("function", "name"),
    [pytest.param(function, name, id=f"{function.__name__}-{name}") for function, name in public_arguments()],
)
def test_every_public_function_names_an_argument_of_the_wrong_kind(
    function: Callable[..., Any], name: str
) -> None:
    with pytest.raises(ArgumentError, match=f"^{function.__name__}: {name} is <object "):
        function(**{name: object()})


class Colour(StrEnum):
    RED = "red"


class Tell(Protocol):
    def __call__(self, text: str) -> None: ...


@pytest.mark.parametrize(
    ("hint", "right", "wrong", "words"),
    [
        (int, [3, np.int64(3), -1], [True, 3.0, "3", None], "a whole number"),
        (float, [3, 0.5, np.float32(1), np.int8(1), float("nan")], ["1", True, 1j], "a number"),
        (bool, [True, np.bool_(False)], [0, "no", None], "True or False"),
        (str, ["", "a"], [Path("a"), 3, b"a"], "a text"),
        (str | Path, ["a", Path("a")], [3, None, ["a"]], "a path"),
        (float | None, [None, 2], ["2"], "a number or None"),
        (
            Sequence[str],
            [["a"], ("a",), [], pd.Series(["a"]), np.array(["a"])],
            ["a", [1], {"a": 1}],
            "a list of texts",
        ),
        (Iterable[str], [["a"], {"a"}, {"a": 1}, iter(["a"])], ["a", 3, None], "a list of texts"),
        (Mapping[str, int], [{}, {"a": 1}], [{"a": "b"}, [("a", 1)], "a"], "a dictionary"),
        (
            tuple[float, float, float],
            [(1, 2, 3), [1.0, 2, 3], np.zeros(3)],
            [(1, 2), "abc", 3.0],
            "3 numbers",
        ),
        (tuple[str, ...], [(), ("a",), ["a"]], ["a", (1,)], "a list of texts"),
        (Callable[[float], None], [print, lambda t: None], ["print", None], "a function"),
        (Tell, [print], ["print", 3], "a function"),
        (Literal["a", "b"], ["a"], ["c", None, np.array(["a", "b"])], "'a' or 'b'"),
        (Colour, [Colour.RED, "red"], ["blue", 3], "'red'"),
        (type, [int], [3, "int"], "a class"),
        (FloatArray, [np.zeros(2), [1.0]], ["ab", 3.0, None], "an array"),
        (
            npt.ArrayLike,
            [3, [1, 2], np.zeros(2), [True]],
            ["ab", None, {"a": 1}, object()],
            "a number, or numbers",
        ),
        (npt.ArrayLike | None, [None, 3], ["ab"], "a number, or numbers"),
        (nrp_core.Pose, [nrp_core.Pose()], [(0, 0, 0)], "a Pose"),
        (Any, [None, object()], [], "an Any"),
    ],
)
def test_a_hint_admits_what_users_mean_by_it(
    hint: Any, right: list[Any], wrong: list[Any], words: str
) -> None:
    assert [value for value in right if not admits(hint, value)] == []
    assert [value for value in wrong if admits(hint, value)] == []
    assert in_words(hint) == words


@checks_arguments("own")
def sized(size: int, *more: int, own: int = 0, unit: str = "mm", **named: float) -> tuple[Any, ...]:
    """Return what it is given."""
    return size, more, own, unit, named


def test_a_valid_argument_arrives_unchanged() -> None:
    assert sized(1, 2, 3, own="anything", unit="m", depth=0.5) == (1, (2, 3), "anything", "m", {"depth": 0.5})  # type: ignore[arg-type]
    assert inspect.signature(sized) == inspect.signature(inspect.unwrap(sized))


def event() -> Any:
    return nrp_core.brains().load("event")


def mujoco() -> Any:
    return nrp_core.worlds().load("mujoco")


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: sized("1"), "sized: size is '1'; it must be a whole number"),
        (lambda: sized(1, 2, 3.5), "sized: more is 3.5; it must be a whole number"),
        (lambda: sized(1, depth="deep"), "sized: depth is 'deep'; it must be a number"),
        (lambda: sized(), "sized: missing a required argument: 'size'"),
        (
            lambda: nrp_core.run("x", untill_s=1.0),
            "got an unexpected keyword argument 'untill_s'; did you mean 'until_s'?",
        ),
        (
            lambda: event().open(None),
            "EventBackend.open: network is None; it must be",
        ),
        (
            lambda: (
                nrp_core.brains()
                .load("event")
                .open(nrp_core.Network({}), seed=1, options={"resolution": "1 ms"})
            ),
            "EventBackend.open: options is {'resolution': '1 ms'}; it must be an EventOptions",
        ),
        (
            lambda: mujoco().open(nrp_core.Scene(()), seed=1, options={}),
            "MujocoBackend.open: options is {}; it must be a MujocoOptions",
        ),
        (
            lambda: mujoco().open("room.sdf"),
            "open: scene is 'room.sdf'; it must be a Scene",
        ),
        (lambda: nrp_core.brains().load(3), "no brain backend is called '3'; valid: "),
        (
            lambda: nrp_core.Pose.from_rpy((0, 0, 0), 0, 0, "90 deg"),
            "Pose.from_rpy: yaw is '90 deg'; it must",
        ),
        (lambda: Margin("1 s"), "Margin: amount is '1 s'; it must be a number"),
        (
            lambda: nrp_core.Scene((), gravity=(0.0, -9.8)),
            "gravity is (0.0, -9.8); it must be 3 numbers",
        ),
    ],
)
def test_a_wrong_call_is_one_sentence(call: Callable[[], object], words: str) -> None:
    with pytest.raises(nrp_core.NrpError, match=re.escape(words)):
        call()


def test_an_argument_of_the_wrong_kind_is_an_error_of_type_and_value(golden: Golden) -> None:
    with pytest.raises(TypeError):
        sized("1")  # type: ignore[arg-type]
    with golden.raises(ValueError, match="sized: size is '1'"):
        sized("1")  # type: ignore[arg-type]


def test_a_hint_that_only_type_checkers_know_admits_anything(golden: Golden) -> None:
    @dataclass
    class Loose:
        size: Unknown  # type: ignore[name-defined] # noqa: F821
        name: str

    require_fields(Loose(3, "a"), "loose")
    with golden.raises(ArgumentError, match="name is 3"):
        require_fields(Loose(3, 3), "loose")  # type: ignore[arg-type]


def test_names_that_nothing_has_are_refused_by_scenes_networks_and_worlds(golden: Golden) -> None:
    scene, network = nrp_core.Scene(()), nrp_core.Network({})
    for look in (lambda: scene.without("hsky"), lambda: scene.with_pose("hsky", nrp_core.Pose())):
        with golden.raises(SceneError, match="'hsky'"):
            look()
    with golden.raises(NeuronSelectionError, match="'eyes'"):
        network.ids_of("eyes")
    backend = mujoco()
    with backend.open(scene, seed=1, options=backend.options()) as world:
        for ask in (world.model_motion, world.joint_states):
            with golden.raises(SceneError, match="'hsky'"):
                ask("hsky")


def test_a_closer_hint_is_not_for_the_rest_of_the_arguments_under_its_name() -> None:
    @checks_arguments(options=str)
    def opened(*arguments: Any, **options: Any) -> tuple[Any, Any]:
        return arguments, options

    assert opened(1, seed=0, options=2) == ((1,), {"seed": 0, "options": 2})
