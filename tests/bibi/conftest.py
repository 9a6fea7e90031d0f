"""Random models: any, for what must hold of every document, and those that have a meaning."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache
from keyword import iskeyword
from typing import Any

import pytest
from experiment_fixtures import install, site
from hypothesis import strategies as st
from hypothesis.strategies import SearchStrategy
from nrp_bibi.model import channels, functions, selectors, synapses
from nrp_bibi.model import expressions as exprs
from nrp_bibi.model.expressions import FlowExpression
from nrp_bibi.model.functions import Bibi, Calls
from nrp_bibi.model.metamodel import Feature, Node, Value, concrete, features
from nrp_bibi.model.selectors import NeuronGroupSelector
from nrp_bibi.model.values import TEMPLATE, dedented

__all__ = ["install", "site"]

_TEXT = st.text(st.characters(codec="utf-8", exclude_categories=["Cs", "Cc"], include_characters="\t\n\r"))
_NAME = st.from_regex(r"[a-z_][a-z0-9_]{0,6}", fullmatch=True).filter(lambda name: not iskeyword(name))
_DOTTED = st.lists(_NAME, min_size=1, max_size=3).map(".".join)
_FILE = st.from_regex(r"[a-z0-9._/&-]{1,8}", fullmatch=True)
_CODE = st.lists(st.sampled_from(["x = 1", "if x:", "    y = ']]>'", "", "def f(t):", "\treturn <&>"]))
_NUMBER = st.one_of(st.integers(-(10**6), 10**6), st.floats(allow_nan=False, allow_infinity=False))
_TERM = st.sampled_from(["i", "2 * i + 1", "(i + 1) * 3", "7"]).map(TEMPLATE.parse)
_VALUES: dict[str, SearchStrategy[Any]] = {
    "Text": _TEXT,
    "Code": _CODE.map("\n".join).map(dedented),
    "Word": st.from_regex(r"[A-Za-z][\w]{0,8}", fullmatch=True),
    "File": _FILE,
    "Number": _NUMBER,
    "Natural": st.integers(0, 1000),
    "Positive": st.integers(1, 1000),
    "Rate": st.integers(1, 1000) | st.floats(1e-3, 1e3),
    "Point": st.lists(_NUMBER, min_size=2, max_size=3).map(tuple),
    "Truth": st.booleans(),
    "Name": _NAME,
    "Dotted": _DOTTED,
    "Path": _DOTTED,
    "Topic": st.from_regex(r"(/[a-z0-9_-]{1,4}){1,3}", fullmatch=True),
    "Template": _TERM,
}


SMALL = st.integers(0, 20)
NUMBER = st.one_of(st.integers(-99, 99), st.floats(-1e3, 1e3, allow_nan=False))
POPULATION = st.sampled_from(["sensors", "actors"])
RANGE = st.builds(
    selectors.Range, population=POPULATION, from_=SMALL, to=SMALL, step=st.none() | st.integers(1, 4)
)
LIST = st.builds(
    selectors.List, population=POPULATION, element=st.lists(SMALL, min_size=1, max_size=40).map(tuple)
)
NEURONS = RANGE | LIST | st.builds(selectors.Index, population=POPULATION, index=SMALL)
NEURONS |= st.builds(selectors.Population, population=POPULATION)
POINT = st.lists(NUMBER, min_size=2, max_size=3).map(tuple)
NEURONS |= st.one_of(
    st.builds(selectors.Box, population=POPULATION, low=POINT, high=POINT),
    st.builds(
        selectors.Sphere, population=POPULATION, center=POINT, radius=st.integers(1, 99) | st.floats(0.1, 9)
    ),
    st.builds(selectors.Nearest, population=POPULATION, center=POINT, count=st.none() | st.integers(1, 9)),
)
TERM = st.sampled_from(["i", "2 * i + 1", "3", "(i + 1) * 2"])
PATTERN = st.one_of(
    st.builds(selectors.IndexTemplate, population=POPULATION, index=TERM),
    st.builds(selectors.RangeTemplate, population=POPULATION, from_=TERM, to=TERM, step=st.none() | TERM),
    st.builds(
        selectors.ListTemplate,
        population=POPULATION,
        element=st.lists(TERM, min_size=1, max_size=3).map(tuple),
    ),
)
MAP = st.builds(selectors.MapSelector, count=SMALL, pattern=PATTERN)
MAP |= st.builds(
    selectors.MapSelector,
    source=RANGE | LIST | st.builds(selectors.Population, population=POPULATION),
    pattern=PATTERN,
)
GROUP = MAP | st.builds(
    selectors.ChainSelector,
    neurons=st.lists(NEURONS, min_size=1, max_size=2).map(tuple),
    connectors=st.lists(MAP, max_size=2).map(tuple),
)
SETTINGS: dict[str, SearchStrategy[Any]] = {
    "type": st.sampled_from(channels.DeviceType),
    "connector": st.none()
    | st.builds(synapses.OneToOneConnector, weights=NUMBER, delays=st.none() | NUMBER)
    | st.builds(synapses.FixedNumberPreConnector, count=st.integers(1, 9), weights=st.none() | NUMBER),
    "synapse_dynamics": st.none()
    | st.builds(synapses.TsodyksMarkramMechanism, u=NUMBER, tau_rec=NUMBER, tau_facil=NUMBER),
    "target": st.none() | st.sampled_from(channels.Target),
}
TOPIC: dict[str, SearchStrategy[Any]] = {
    "topic": st.just("/husky/a_topic"),
    "type": st.just("std_msgs.msg.Float64"),
}


_OPERATORS = [exprs.Add, exprs.Subtract, exprs.Multiply, exprs.Divide, exprs.Min, exprs.Max]


def _expressions(
    leaves: SearchStrategy[FlowExpression], calls: Sequence[str] = ("abs",), most: int = 1
) -> SearchStrategy[FlowExpression]:
    """Expressions over some leaves and numbers, with calls that take so many arguments at most."""

    def deeper(inner: SearchStrategy[FlowExpression]) -> SearchStrategy[FlowExpression]:
        operands = st.lists(inner, min_size=2, max_size=3).map(tuple)
        plain = st.lists(st.builds(exprs.Argument, value=inner), min_size=1, max_size=most).map(tuple)
        named = st.builds(exprs.Argument, name=st.just("x"), value=inner).map(lambda one: (one,))
        arguments = (
            plain
            if most == 1
            else st.one_of(plain, named, st.tuples(plain, named).map(lambda p: p[0] + p[1]))
        )
        return st.one_of(
            st.builds(lambda kind, operand: kind(operand=operand), st.sampled_from(_OPERATORS), operands),
            st.builds(exprs.Scale, factor=NUMBER, inner=inner),
            st.builds(exprs.Call, type=st.sampled_from(calls), argument=arguments),
        )

    return st.recursive(st.builds(exprs.Constant, value=NUMBER) | leaves, deeper, max_leaves=12)


def _over(names: list[str]) -> SearchStrategy[FlowExpression]:
    """Expressions of every kind over channels and locals."""
    properties = st.sampled_from([None, "a", "a.b"])
    leaves = st.one_of(
        st.builds(exprs.SimulationStep),
        st.builds(exprs.ConstantString, value=st.text("ab \"'<&é\\", max_size=3)),
        st.builds(exprs.ArgumentReference, name=st.sampled_from(names), property=properties),
    )
    return _expressions(leaves, ["abs", "math.sqrt", "nrp.tf_lib.detect_red"], most=2)


@st.composite
def _functions(draw: st.DrawFn, name: str) -> Any:
    """A transfer function with every kind of channel, read or written."""
    if draw(st.integers(0, 9)) == 0:
        device = st.builds(channels.DeviceChannel, name=st.just(name), neurons=NEURONS, **SETTINGS)
        return functions.Neuron2Monitor(name=name, device=draw(device), active=draw(st.booleans()))
    body = st.none() | _over(["left_eye", "a_local", "camera", "group"])
    first = _over(["left_eye", "camera", "group"])
    device = st.builds(
        channels.DeviceChannel, name=st.just("left_eye"), neurons=NEURONS, body=body, **SETTINGS
    )
    group = st.builds(
        channels.DeviceGroupChannel, name=st.just("group"), neurons=GROUP, body=body, **SETTINGS
    )
    topic = draw(st.builds(channels.TopicChannel, name=st.just("camera"), body=body, **TOPIC))
    triggers = ["camera"] if topic.body is None else []
    values: dict[str, Any] = {
        "name": name,
        "active": draw(st.booleans()),
        "priority": draw(SMALL),
        "device": (draw(device),),
        "device_group": (draw(group),),
        "topic": (topic,),
        "throttling_rate": draw(st.none() | _VALUES["Rate"]),
        "trigger": tuple(triggers if (chosen := draw(st.booleans())) else ()),
        "calls": draw(st.sampled_from(Calls)) if chosen and triggers else Calls.ONCE,
        "local": (channels.Local(name="a_local", body=draw(first)),),
    }
    if draw(st.booleans()):
        return functions.Robot2Neuron(**values)
    returned = st.builds(channels.TopicChannel, body=_over(["left_eye", "a_local"]), **TOPIC)
    return functions.Neuron2Robot(**values, return_value=draw(st.none() | returned))


_MODELS = st.builds(lambda *found: Bibi(transfer_function=found), _functions("first"), _functions("second"))


@pytest.fixture(scope="session")
def expressions() -> Callable[..., SearchStrategy[FlowExpression]]:
    """Makes expressions over given leaves."""
    return _expressions


@pytest.fixture(scope="session")
def models() -> SearchStrategy[Bibi]:
    """Models that have a meaning, with two transfer functions of every kind of channel."""
    return _MODELS


@pytest.fixture(scope="session")
def documents() -> SearchStrategy[Bibi]:
    """Every model that the metamodel can hold, whether it has a meaning or not."""
    return _any(Bibi, 4)


@cache
def _any(of: type[Node], depth: int) -> SearchStrategy[Any]:
    choices = list(concrete(of).values())
    if depth <= 0 and of in (FlowExpression, NeuronGroupSelector):
        choices = [choice for choice in choices if not _nests(choice)]
    return st.one_of([_object(choice, depth - 1) for choice in choices])


def _nests(node: type[Node]) -> bool:
    return any(not isinstance(feature.of, Value) and feature.least for feature in features(node))


def _object(node: type[Node], depth: int) -> SearchStrategy[Any]:
    return st.builds(node, **{feature.field: _of_feature(node, feature, depth) for feature in features(node)})


def _of_feature(node: type[Node], feature: Feature, depth: int) -> SearchStrategy[Any]:
    if depth <= 0 and not feature.least and not isinstance(feature.of, Value):
        return st.just(()) if feature.many else st.none()
    one = _of(feature.of, depth)
    if feature.many:
        return st.lists(one, min_size=feature.least, max_size=feature.least + 2).map(tuple)
    may_be_none = node.__dataclass_fields__[feature.field].default is None
    return st.none() | one if may_be_none else one


def _of(of: Value | type[Node], depth: int) -> SearchStrategy[Any]:
    if not isinstance(of, Value):
        return _any(of, depth)
    if of.name in _VALUES:
        return _VALUES[of.name]
    return st.sampled_from([of.parse(text) for facet, text in of.facets if facet == "enumeration"])
