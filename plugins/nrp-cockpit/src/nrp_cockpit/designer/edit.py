"""The commands that change a model of transfer functions."""

from __future__ import annotations

import ast
import re
from dataclasses import replace
from typing import Any

from nrp_bibi.generation.walk import channels
from nrp_bibi.model.expressions import ArgumentReference, FlowExpression
from nrp_bibi.model.functions import Bibi, BIBITransferFunction, ChannelTransferFunction
from nrp_bibi.model.metamodel import Node
from nrp_bibi.reverse.expressions import as_expression
from nrp_bibi.reverse.refusal import NotExpressibleError

from nrp_cockpit.designer.changes import Changes
from nrp_cockpit.designer.fresh import Fresh
from nrp_cockpit.designer.surroundings import Surroundings
from nrp_cockpit.designer.tree import at, feature_of, function_of, replaced, walk
from nrp_core.errors import ExperimentError, did_you_mean


class Edit(Changes):
    """Changes of a model of transfer functions.

    Args:
        model: the current model.
        surroundings: the topics and populations around it.
    """

    model: Bibi

    def __init__(self, model: Bibi, surroundings: Surroundings) -> None:
        super().__init__(model)
        self.surroundings = surroundings

    def write(self, path: str, field: str, text: str) -> None:
        """Set an expression given as Python; an empty text removes an optional one."""
        node = at(self.model, path)
        feature = feature_of(node, field)
        if not (isinstance(feature.of, type) and issubclass(feature.of, FlowExpression)) or feature.many:
            raise ExperimentError(f"'{feature.name}' is not an expression")
        if not text.strip():
            if feature.least:
                raise ExperimentError(f"'{feature.name}' needs an expression")
            self.model = replaced(self.model, path, replace(node, **{field: None}))
            return
        known = names_in(at(self.model, function_of(path)))
        self.model = replaced(self.model, path, replace(node, **{field: expression_of(text, known)}))

    def function(self, path: str) -> BIBITransferFunction | None:
        """Return the function of blocks that contains a part."""
        found = at(self.model, function_of(path)) if function_of(path) else None
        return found if isinstance(found, BIBITransferFunction) else None

    # --

    def _make(self, path: str, kind: type[Node], **given: Any) -> Any:
        return self._fresh(path).make(kind, **given)

    def _free_name(self, path: str, wanted: str) -> str:
        return self._fresh(path).name(wanted)

    def _left(self, owner: str) -> str | None:
        return function_of(owner) or None

    def _renamed(self, path: str, before: str, after: str) -> None:
        """Write the new name of a channel or local where expressions and triggers refer to it."""
        function = function_of(path)
        if function in ("", path):
            return
        for below, part in list(walk(at(self.model, function), function)):
            if isinstance(part, ArgumentReference) and part.name == before and after:
                self.model = replaced(self.model, below, replace(part, name=after))
            elif isinstance(part, ChannelTransferFunction) and before in part.trigger and after:
                trigger = tuple(after if name == before else name for name in part.trigger)
                self.model = replaced(self.model, f"{below}/trigger", trigger)

    def _fresh(self, path: str) -> Fresh:
        return Fresh(self.model, self.surroundings, self.function(path))


def names_in(function: Node) -> list[str]:
    """Return the names that expressions of a function can refer to."""
    if not isinstance(function, BIBITransferFunction):
        return []
    return [str(part.name) for part in (*channels(function), *function.local) if part.name]


def expression_of(text: str, known: list[str]) -> FlowExpression:
    """Return a Python expression as building blocks.

    Raises:
        ExperimentError: it is not an expression, or cannot be expressed as blocks.
    """
    try:
        return as_expression(ast.parse(text.strip(), mode="eval").body, frozenset(known))
    except SyntaxError as error:
        raise ExperimentError(f"this is not an expression: {error.msg}") from None
    except NotExpressibleError as error:
        what = str(error)
        if re.fullmatch(r"\w+(\.\w+)*", what):
            hint = did_you_mean(what.partition(".")[0], known)
            raise ExperimentError(f"this function has no channel or local '{what}'{hint}") from None
        raise ExperimentError(f"'{what}' cannot be expressed as blocks; write a Python function") from None
