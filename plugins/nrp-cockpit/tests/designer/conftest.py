"""Models to draw: the random ones are those with which BIBI itself is tested."""

from __future__ import annotations

import importlib.util
from pathlib import Path
from typing import Any

import pytest
from drawing import HUSKY, ROOT, Drawing
from nrp_cockpit.designer.document import Document

_spec = importlib.util.spec_from_file_location("models_of_bibi", ROOT / "tests" / "bibi" / "conftest.py")
assert _spec is not None
assert _spec.loader is not None
_random: Any = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(_random)
documents, models = _random.documents, _random.models


@pytest.fixture
def drawing(tmp_path: Path) -> Drawing:
    """An empty canvas beside the Husky."""
    return Drawing(Document(tmp_path / "new.bibi", HUSKY))
