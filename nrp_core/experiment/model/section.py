"""The base of all sections of an experiment file: unknown keys are refused, names are checked."""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import Annotated

from pydantic import AfterValidator, BaseModel, ConfigDict, Field


class Section(BaseModel):
    """Base of every section; the docstrings of its fields are their documentation, also in editors."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False, use_attribute_docstrings=True)

    def _require_one_of(self, names: Iterable[str]) -> None:
        """Refuse a section without exactly one of its alternatives.

        Raises:
            ValueError: there are none or several.
        """
        given = [name for name in names if getattr(self, name) is not None]
        if len(given) != 1:
            found = " and ".join(f"'{name}'" for name in given) or "none"
            raise ValueError(f"needs exactly one of {', '.join(names)}; it has {found}")


def _identifier(name: str) -> str:
    if not name.isidentifier():
        raise ValueError(f"a name has letters, digits and '_', and no digit first: not '{name}'")
    return name


def _absolute(topic: str) -> str:
    if not re.fullmatch(r"(/\w+)+", topic):
        raise ValueError(f"a topic reads like '/husky/camera', not '{topic}'")
    return topic


Name = Annotated[str, AfterValidator(_identifier), Field(json_schema_extra={"pattern": r"^[A-Za-z_]\w*$"})]
"""Name of a thing of the experiment: a robot, an event, a criterion, a population."""

TopicName = Annotated[str, AfterValidator(_absolute), Field(json_schema_extra={"pattern": r"^(/\w+)+$"})]
"""Absolute name of a topic."""
