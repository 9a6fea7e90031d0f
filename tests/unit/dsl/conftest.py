"""A file of transfer functions, written on the spot."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from textwrap import dedent

import pytest

from nrp_core.dsl.functions import TransferFunction
from nrp_core.dsl.loading import load_transfer_functions

Load = Callable[[str], list[TransferFunction]]


@pytest.fixture
def load(tmp_path: Path) -> Load:
    """Load transfer functions from a text, as the file ``functions.py``."""

    def load_text(text: str) -> list[TransferFunction]:
        path = tmp_path / "functions.py"
        path.write_text(dedent(text).lstrip("\n"))
        return load_transfer_functions(path)

    return load_text
