"""Files for containers, conda, Binder and forges name things of this repository that exist."""

import json
import os
import re
import tomllib
from pathlib import Path

import pytest
from ruamel.yaml import YAML

ROOT = Path(__file__).parents[2]
EXTRAS = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["optional-dependencies"]
FILES = {
    name: (ROOT / name).read_text()
    for name in (
        "packaging/Containerfile", "packaging/environment.yml", "binder/postBuild", "scripts/artifacts",
        ".devcontainer/devcontainer.json", ".github/workflows/release.yml", ".gitlab-ci.yml",
    )
}  # fmt: skip


@pytest.mark.parametrize("name", FILES)
def test_scripts_and_extras_that_it_names_exist(name: str) -> None:
    for script in re.findall(r"(?<![\w/])scripts/[\w.-]*\w", FILES[name]):
        assert os.access(ROOT / script, os.R_OK if script.endswith(".whl") else os.X_OK), script
    for extras in re.findall(r"(?:nrp-core|'\.)\[([\w,]+)\]", FILES[name]):
        assert set(extras.split(",")) <= EXTRAS.keys()


def test_its_syntax_is_valid() -> None:
    assert "scripts/setup" in json.loads(FILES[".devcontainer/devcontainer.json"])["postCreateCommand"]
    read = {name: YAML(typ="safe").load(text) for name, text in FILES.items() if name.endswith(".yml")}
    assert read["packaging/environment.yml"]["dependencies"][0].startswith("python=")
    assert read[".gitlab-ci.yml"]["release"]["script"] == ["scripts/artifacts"]
    steps = read[".github/workflows/release.yml"]["jobs"]["release"]["steps"]
    assert {"run": "scripts/artifacts"} in steps
