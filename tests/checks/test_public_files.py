"""Correct public robots, rooms and brains give few warnings; their codes are listed with a verdict.

The files are those of installed packages: `pip install --no-deps dm-control example-robot-data
gymnasium-robotics` brings those that the tests do not need otherwise. A limit counts the lines that commands
print, one for each code of a file. PyNN's examples are read from its source archive.
"""

from __future__ import annotations

import hashlib
import os
import re
import tarfile
from collections import Counter
from collections.abc import Iterator
from importlib.metadata import PackageNotFoundError, distribution
from pathlib import Path
from statistics import median

import pytest
import yaml

from nrp_core.checks.network_summary import summary_of
from nrp_core.checks.network_units import unlikely_units
from nrp_core.checks.validate import validate_file
from nrp_core.errors import NrpError
from nrp_core.findings import Code, Finding, Level
from nrp_core.network.files.script import load_network
from nrp_core.scene.sdf import read_model
from nrp_core.scene.tessellation import box_around

PACKAGES = ("dm-control", "example-robot-data", "gymnasium", "gymnasium-robotics", "pybullet")
LISTED: dict[str, dict[str, object]] = yaml.safe_load(
    (Path(__file__).parent / "public_files.yaml").read_text("utf-8")
)
MEDIAN, SHARE, MANY = 1, 0.05, 3
"""Limits of the median of the lines, and of the share of files with more than three."""
GENERATED, NTH = "random_urdfs", 100
"""The folder of ``pybullet_data`` with a thousand files of one kind, of which every hundredth counts."""
NOT_WHOLE = {"test", "testing", "test_assets"}
ARCHIVE = "da2821e45055a88de6cf34896067eaaebcabbfdfb7883dd147353e7b78617815"
"""SHA-256 of ``pynn-0.13.0.tar.gz`` of the Python Package Index."""
FLOOR = """<sdf version="1.6"><world name="room"><model name="ground"><static>true</static><link name="l">
<collision name="c"><geometry><plane><normal>0 0 1</normal></plane></geometry></collision>
<visual name="v"><geometry><plane><normal>0 0 1</normal><size>50 50</size></plane></geometry></visual>
</link></model></world></sdf>"""
BRAIN = "import nrp_core.pynn as sim\nsim.setup()\ncells = sim.Population(2, sim.IF_cond_exp())\n"


def public_files() -> list[Path]:
    """Return the models of the installed packages; without any of these packages there are none."""
    found: list[Path] = []
    for package in PACKAGES:
        try:
            files = distribution(package).files or []
        except PackageNotFoundError:
            continue
        paths = sorted(Path(str(one.locate())) for one in files if one.suffix in (".urdf", ".sdf", ".xml"))
        generated = [one for one in paths if GENERATED in one.parts]
        found += [one for one in paths if GENERATED not in one.parts and is_model(one)] + generated[::NTH]
    return found


def is_model(path: Path) -> bool:
    text = path.read_text("utf-8", errors="replace")
    if NOT_WHOLE & set(path.parts) or "<mujocoinclude" in text:
        return False
    if "<mujoco" in text:
        return "<worldbody" in text and ("<geom" in text or "<include" in text)
    return re.search(r"<(robot|sdf|gazebo)[\s>]", text) is not None


def warnings_about(path: Path, folder: Path) -> list[Finding] | None:
    """Return the warnings about an experiment with a file as its robot, or else its room; None if refused."""
    (folder / "floor.sdf").write_text(FLOOR)
    (folder / "brain.py").write_text(BRAIN)
    placed = f"model: '{path}', pose: [0, 0, {height_m(path)}, 0, 0, 0]"
    robot = f"{{scene: floor.sdf, robots: {{robot: {{{placed}}}}}}}"
    for world in (robot, f"{{scene: '{path}'}}"):
        if world is robot and is_room(path):
            continue
        (folder / "public.yaml").write_text(
            "name: public\nduration: 1 s\ntimestep: 20 ms\nbrain: {backend: event, model: brain.py}\n"
            f"world: {world.replace('{', '{backend: mujoco, ', 1)}\ntransfer_functions: []\n"
        )
        found = validate_file(folder / "public.yaml")
        if all(one.level is not Level.ERROR for one in found):
            return [one for one in found if one.level is Level.WARNING]
    return None


def is_room(path: Path) -> bool:
    text = path.read_text("utf-8", errors="replace")
    return path.suffix != ".urdf" and ('type="plane"' in text if "<mujoco" in text else "<world" in text)


def height_m(path: Path) -> float:
    """Return the height of the origin of a robot that stands on its lowest point."""
    try:
        model = read_model(path, name="robot")
        box = box_around(
            (link.pose @ one.pose, one.geometry)
            for link in model.links
            for one in link.collisions or link.visuals
        )
    except NrpError:
        return 0.0
    return 0.0 if box is None else round(1e-3 - float(box[0][2]), 4)


def check_limits(files: list[Path], folder: Path) -> Counter[Code]:
    """Check the limits of lines for files; return the number of warnings by code."""
    warnings = [found for path in files if (found := warnings_about(path, folder)) is not None]
    lines = [len({one.code for one in found}) for found in warnings]
    assert len(lines) > 0.85 * len(files)
    assert median(lines) <= MEDIAN
    assert sum(count > MANY for count in lines) <= SHARE * len(lines)
    return Counter(one.code for found in warnings for one in found)


@pytest.mark.slow
def test_a_sample_of_public_files_gives_few_warnings(tmp_path: Path) -> None:
    files = public_files()
    if not files:
        pytest.skip("no package with public models is installed")
    counts = check_limits(files[::12], tmp_path)
    assert {code.name for code in counts} <= LISTED.keys()


@pytest.mark.heavy
def test_public_files_give_few_warnings_of_known_codes(tmp_path: Path) -> None:
    counts = check_limits(public_files(), tmp_path)
    beyond = {
        code.name: count
        for code, count in counts.items()
        if count > int(str(LISTED.get(code.name, {}).get("at_most", 0)))
    }
    assert beyond == {}


def test_each_listed_code_exists_and_has_a_verdict() -> None:
    assert LISTED.keys() <= Code.__members__.keys()
    assert {str(one["verdict"]).lower() for one in LISTED.values()} <= {"true", "noise", "false"}


def example_scripts(folder: Path) -> Iterator[Path]:
    """Yield PyNN's examples up to the line that runs them, for a simulator named by their arguments."""
    archive = Path(os.environ.get("NRP_PYNN_ARCHIVE", ""))
    if not archive.is_file():
        pytest.skip("NRP_PYNN_ARCHIVE names no file: pip download --no-deps --no-binary pynn pynn==0.13.0")
    assert hashlib.sha256(archive.read_bytes()).hexdigest() == ARCHIVE
    with tarfile.open(archive) as opened:
        opened.extractall(folder, filter="data")
    for path in sorted(folder.glob("*/examples/*.py")):
        text = re.sub(r"get_script_args\((\d).*?\)", r"(['nest'] + ['1'] * 9)[:\1]", path.read_text("utf-8"))
        head = re.split(r"^(?:sim\.|\w+ = )?run(?:_for|_until)?\(", text, maxsplit=1, flags=re.MULTILINE)[0]
        path.write_text(head)
        yield path


@pytest.mark.slow
def test_pynns_examples_are_in_their_units(tmp_path: Path) -> None:
    found, n_loaded = {}, 0
    for path in example_scripts(tmp_path):
        try:
            network = load_network(path)
        except NrpError:  # it needs another simulator, or runs in a loop
            continue
        n_loaded += 1
        leading_on = {projection.pre for projection in network.projections}
        silent = [one for label, one in summary_of(network).unreached.items() if label in leading_on]
        found[path.name] = [*unlikely_units(network), *silent]
    assert n_loaded >= 8
    assert {name: sentences for name, sentences in found.items() if sentences} == {}
