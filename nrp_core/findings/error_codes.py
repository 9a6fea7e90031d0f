"""The code of the finding that reports an error."""

from __future__ import annotations

from typing import Final

from nrp_core.errors import (
    BackendError,
    CapabilityError,
    EndlessScriptError,
    NeuronSelectionError,
    OutsideFolderError,
    ParameterError,
    SlowScriptError,
    TopicError,
    TriggerError,
    UncheckedScriptError,
)
from nrp_core.findings.codes import Code

_CODES: Final = {
    BackendError: Code.NRP205,
    NeuronSelectionError: Code.NRP211,
    TopicError: Code.NRP212,
    CapabilityError: Code.NRP216,
    SlowScriptError: Code.NRP239,
    UncheckedScriptError: Code.NRP239,
    EndlessScriptError: Code.NRP208,
    ParameterError: Code.NRP202,
    TriggerError: Code.NRP210,
    OutsideFolderError: Code.NRP210,
}


def code_of(error: Exception, otherwise: Code) -> Code:
    """Return the code that the class of an error has, or ``otherwise``."""
    return next((code for kind, code in _CODES.items() if isinstance(error, kind)), otherwise)
