"""Received messages that are changed, or asked for joints and angles that they do not have."""

from __future__ import annotations

import ast
from collections.abc import Iterator

from nrp_core.checks.declared import found_in
from nrp_core.checks.registry import checks_experiment
from nrp_core.checks.scopes import own_nodes
from nrp_core.checks.static_experiment import CheckedFunction, StaticExperiment
from nrp_core.dsl.functions.mappings import MapRobotSubscriber
from nrp_core.errors import did_you_mean
from nrp_core.findings import Code, Finding, Level


@checks_experiment(Code.NRP332)
def joints_of_messages_exist(static: StaticExperiment) -> Iterator[Finding]:
    """Look for names of joints that the messages of a robot do not have."""
    if static.scene is None:
        return
    joints = {
        one.joint_states_topic: [
            *(joint.name for joint in one.joints),
            *(pair.name for pair in one.pair_controllers),
        ]
        for one in static.scene.models
        if one.joint_states_topic is not None
    }
    aliases = static.experiment.aliases
    for function in static.functions:
        received = _received(function)
        for node in function.declared.own:
            match node:
                case ast.Call(
                    ast.Attribute(ast.Attribute(owner, "name"), "index"), [ast.Constant(str() as name)]
                ) | ast.Compare(
                    ast.Constant(str() as name), [ast.In() | ast.NotIn()], [ast.Attribute(owner, "name")]
                ):
                    topic = received.get(ast.unparse(owner), "")
                    known = joints.get(aliases.get(topic, topic))
                    if known is not None and name not in known:
                        message = f"'{topic}' has no joint '{name}'{did_you_mean(name, known)}"
                        yield function.declared.finding(Code.NRP332, node, message, Level.WARNING)


@checks_experiment(Code.NRP356)
def preprocessed_messages_are_returned(static: StaticExperiment) -> Iterator[Finding]:
    """Look for functions of preprocessed topics that return nothing, so that ``value`` is None."""
    for source in [source for listing in static.listings for source in listing.sources]:
        defined = {one.name: one for one in ast.walk(source.tree) if isinstance(one, ast.FunctionDef)}
        for node in ast.walk(source.tree):
            match node:
                case ast.Call(func, [_, _, ast.Name(name), *_]) if name in defined:
                    returned = [one for one in own_nodes(defined[name].body) if isinstance(one, ast.Return)]
                    if ast.unparse(func).endswith("PreprocessedTopic") and not any(
                        one.value is not None for one in returned
                    ):
                        message = (
                            f"'{name}' returns nothing, and its result is the message: it is always None"
                        )
                        yield found_in(source, Code.NRP356, node, message, Level.WARNING)


def _received(function: CheckedFunction) -> dict[str, str]:
    """Return the topics of the expressions that are received messages: ``camera.value`` and its aliases."""
    mappings = function.function.mappings
    found = {
        f"{name}.value": one.reads.name
        for name, one in mappings.items()
        if isinstance(one, MapRobotSubscriber)
    }
    for node in function.declared.own:
        match node:
            case ast.Assign([ast.Name(alias)], ast.Attribute() as value) if ast.unparse(value) in found:
                found[alias] = found[ast.unparse(value)]
    return found
