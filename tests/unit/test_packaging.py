"""Files for containers, conda, Binder and forges name things of this repository that exist."""

import json
import os
import re
import subprocess
import tomllib
import venv
from pathlib import Path

import pytest
from ruamel.yaml import YAML

ROOT = Path(__file__).parents[2]
EXTRAS = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["optional-dependencies"]
FILES = {
    name: (ROOT / name).read_text()
    for name in (
        "packaging/Containerfile", "scripts/container", "packaging/environment.yml", "binder/postBuild",
        "scripts/artifacts", ".devcontainer/devcontainer.json", ".github/workflows/release.yml",
        ".gitlab-ci.yml",
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


@pytest.mark.heavy
def test_what_binder_and_colab_run_prepares_the_notebooks(tmp_path: Path) -> None:
    venv.create(tmp_path, with_pip=True)
    python = tmp_path / "bin" / "python"
    subprocess.run(
        ["bash", ROOT / "binder/postBuild"], env={**os.environ, "NRP_PYTHON": str(python)}, check=True
    )
    imports = "import elephant, matplotlib, nrp_core, nrp_lab, pandas"
    subprocess.run([python, "-P", "-c", imports], cwd=tmp_path, check=True)
