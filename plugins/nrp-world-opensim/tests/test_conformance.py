"""What every world with its own scene must do, from the platform's own kit."""

from pathlib import Path

import pytest
from nrp_conformance import OwnSceneTests

from own_models import arm, written


class TestOpensim(OwnSceneTests):
    """An arm with two muscles, one of which wraps."""

    backend_name = "opensim"

    @pytest.fixture(autouse=True)
    def _arm(self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setattr(type(self), "scene", str(written(arm(), tmp_path)))
