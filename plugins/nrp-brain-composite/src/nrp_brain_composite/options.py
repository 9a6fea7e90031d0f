"""The parts of a composite brain, as an experiment gives them."""

from __future__ import annotations

from typing import Any, Self

from pydantic import Field, PrivateAttr, ValidationError, model_validator

from nrp_core.brain import BrainBackend, BrainCapabilities, BrainOptions
from nrp_core.brain.backends import brains
from nrp_core.errors import BackendError


class PartOptions(BrainOptions):
    """One part: a backend and its populations."""

    backend: str = Field(default="event", description="name of the brain backend that simulates the part")
    options: dict[str, Any] = Field(default_factory=dict, description="options of that backend")
    populations: tuple[str, ...] | None = Field(
        default=None,
        description="its populations, by label, by the name of their model, or by a pattern like `red.*`; by "
        "default those of the model that is called as the part, or else all that no other part has; several "
        "such parts share them",
    )
    process: bool = Field(
        default=False,
        description="whether it runs in a process of its own, while the other parts run: faster if a step "
        "takes much longer than the exchange of spikes, about 0.1 ms",
    )

    _backend: BrainBackend = PrivateAttr()
    _own: BrainOptions = PrivateAttr()

    @model_validator(mode="after")
    def _load(self) -> Self:
        try:
            self._backend = brains().load(self.backend)
            self._own = self._backend.options.model_validate(self.options)
        except BackendError as error:
            raise ValueError(str(error)) from None
        except ValidationError as error:
            wrong = (f"options.{'.'.join(map(str, one['loc']))}: {one['msg']}" for one in error.errors())
            raise ValueError("; ".join(wrong)) from None
        return self

    def title(self, name: str) -> str:
        """Return a name of the part with that of its backend."""
        return f"part '{name}' ({self.backend})"

    @property
    def loaded(self) -> tuple[BrainBackend, BrainOptions]:
        """The backend, and its options in their own type."""
        return self._backend, self._own

    @property
    def capabilities(self) -> BrainCapabilities:
        """The capabilities of the backend with these options."""
        return self._backend.capabilities(self._own)


class CompositeOptions(BrainOptions):
    """Options of the ``composite`` backend."""

    parts: dict[str, PartOptions] = Field(
        default_factory=lambda: {"all": PartOptions()},
        min_length=1,
        description="the parts by name: `{red: {backend: spinnaker}, rest: {backend: event}}`",
    )

    @property
    def inner(self) -> dict[str, BrainOptions]:
        return {f"parts.{name}.options": part.loaded[1] for name, part in self.parts.items()}
