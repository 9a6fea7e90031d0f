"""Plasticity rules that sPyNNaker parametrises in its own way."""

# mypy: disable-error-code="misc"

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

from nrp_core.brain.pynn.arguments import require_names, require_values
from nrp_core.brain.pynn.invalid import InvalidValueError
from nrp_core.clock import MS_PER_S

_VOGELS: Final[Mapping[str, Any]] = {"alpha": None, "tau": 20.0, "A_plus": 0.01, "A_minus": 0.01}
"""Its parameters in order; ``alpha`` has no default, and ``A_minus`` no effect."""


def vogels_rule(pynn: Any) -> type:
    """Return the rule of Vogels et al. (2011, Science 334:1569) with sPyNNaker's parameters.

    Args:
        pynn: the class of PyNN's ``Vogels2011Rule``.
    """

    def begin(self: Any, *values: Any, **given: Any) -> None:
        given |= zip(_VOGELS, values, strict=False)
        require_names("Vogels2011Rule", given, _VOGELS)
        own = {**_VOGELS, **given}
        require_values("Vogels2011Rule", own)
        if own["tau"] <= 0:
            raise InvalidValueError(f"Vogels2011Rule: tau is {own['tau']!r}; it must be more than 0")
        pynn.__init__(self, tau=own["tau"], eta=own["A_plus"], rho=own["alpha"] / (2 * own["tau"]) * MS_PER_S)

    doc = (
        "Each pair of spikes strengthens by ``A_plus``, each spike of the source weakens by ``alpha A_plus``."
    )
    return type("Vogels2011Rule", (pynn,), {"__init__": begin, "__doc__": doc})
