"""The page about the backends says what the backends that ship declare today."""

from __future__ import annotations

import runpy
from pathlib import Path
from typing import Any

import pytest

GENERATOR = Path(__file__).parents[2] / "docs" / "generate_backends.py"


@pytest.fixture(scope="module")
def generator() -> dict[str, Any]:
    return runpy.run_path(str(GENERATOR))


def test_the_page_says_what_the_backends_declare(generator: dict[str, Any]) -> None:
    text = generator["TARGET"].read_text("utf-8")
    assert generator["with_declared"](text) == text, "run docs/generate_backends.py --declared"


def test_a_page_that_lags_behind_is_corrected(generator: dict[str, Any]) -> None:
    text = generator["TARGET"].read_text("utf-8")
    old = text.replace("| determinism | machine |", "| determinism | none |", 1)
    assert old != text
    assert generator["with_declared"](old) == text
