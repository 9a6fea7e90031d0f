"""Files for containers, conda, Binder and forges name things of this repository that exist."""

import json
import os
import re
import subprocess
import sys
import tomllib
import venv
from importlib.metadata import requires
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.specifiers import Specifier, SpecifierSet
from packaging.version import Version
from ruamel.yaml import YAML

ROOT = Path(__file__).parents[2]
EXTRAS = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["optional-dependencies"]
FILES = {
    name: (ROOT / name).read_text()
    for name in (
        "packaging/Containerfile", "scripts/container", "packaging/environment.yml", "binder/postBuild",
        "packaging/conda/recipe.yaml",
        "scripts/artifacts", ".devcontainer/devcontainer.json", ".github/workflows/release.yml",
        ".gitlab-ci.yml",
    )
}  # fmt: skip


@pytest.mark.parametrize("name", FILES)
def test_scripts_and_extras_that_it_names_exist(name: str) -> None:
    for script in re.findall(r"(?<![\w/])scripts/[\w.-]*\w", FILES[name]):
        assert os.access(ROOT / script, os.R_OK if Path(script).suffix else os.X_OK), script
    for extras in re.findall(r"(?:nrp-core|'\.)\[([\w,]+)\]", FILES[name]):
        assert set(extras.split(",")) <= EXTRAS.keys()


def test_its_syntax_is_valid() -> None:
    assert "scripts/setup" in json.loads(FILES[".devcontainer/devcontainer.json"])["postCreateCommand"]
    read = {name: YAML(typ="safe").load(text) for name, text in FILES.items() if name.endswith(".yml")}
    assert read["packaging/environment.yml"]["dependencies"][0].startswith("python=")
    assert read[".gitlab-ci.yml"]["release"]["script"] == ["scripts/artifacts"]
    steps = read[".github/workflows/release.yml"]["jobs"]["release"]["steps"]
    assert {"run": "scripts/artifacts"} in steps


CONDA_NAMES = {"neo": "python-neo", "opencv-python-headless": "py-opencv", "xxhash": "python-xxhash"}


@pytest.mark.skipif(sys.version_info[:2] != (3, 11), reason="the recipe is for Python 3.11")
def test_the_recipe_of_conda_requires_what_its_distributions_require() -> None:
    recipe = YAML(typ="safe").load(FILES["packaging/conda/recipe.yaml"])
    contained = set(recipe["build"]["script"][0].partition("constraints.txt")[2].split())
    required: list[str] = []
    for name in contained:
        folder = ROOT if name == "nrp-core" else ROOT / "plugins" / name
        if (folder / "pyproject.toml").exists():
            project = tomllib.loads((folder / "pyproject.toml").read_text())["project"]
            assert project["version"] == recipe["package"]["version"]
            required += project["dependencies"]
        else:
            required += requires(name) or []
    wanted: dict[str, set[Specifier]] = {}
    for requirement in map(Requirement, required):
        applies = requirement.marker is None or requirement.marker.evaluate(
            {"python_version": "3.11", "extra": ""}
        )
        if applies and requirement.name not in contained:
            wanted.setdefault(CONDA_NAMES.get(requirement.name, requirement.name), set()).update(
                requirement.specifier
            )
    run = dict(line.partition(" ")[::2] for line in recipe["requirements"]["run"])
    assert run.pop("python") == recipe["requirements"]["host"][0].partition(" ")[2] == "3.11.*"
    assert {name: set(SpecifierSet(versions)) for name, versions in run.items()} == {
        name: _narrowest(specifiers) for name, specifiers in wanted.items()
    }


def _narrowest(specifiers: set[Specifier]) -> set[Specifier]:
    """Without the lower bounds that another one makes needless."""
    lower = [specifier for specifier in specifiers if specifier.operator == ">="]
    return specifiers - set(sorted(lower, key=lambda specifier: Version(specifier.version))[:-1])


@pytest.mark.heavy
def test_what_binder_and_colab_run_prepares_the_notebooks(tmp_path: Path) -> None:
    venv.create(tmp_path, with_pip=True)
    python = tmp_path / "bin" / "python"
    subprocess.run(
        ["bash", ROOT / "binder/postBuild"], env={**os.environ, "NRP_PYTHON": str(python)}, check=True
    )
    imports = "import elephant, matplotlib, nrp_core, nrp_lab, pandas"
    subprocess.run([python, "-P", "-c", imports], cwd=tmp_path, check=True)
