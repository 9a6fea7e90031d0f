"""Files made to do harm: entities, archives that reach outside, and doors that are left open."""

from __future__ import annotations

import json
import os
import shutil
import stat
import subprocess
import sys
import zipfile
from pathlib import Path

import nrp_experiments.braitenberg_husky
import pytest
from mutations import limits

from nrp_core.errors import NrpError
from nrp_core.experiment.making.prepare import prepare
from nrp_core.experiment.reading.find import load_experiment

SHIPPED = Path(nrp_experiments.braitenberg_husky.__path__[0])
CORPUS = Path(__file__).parents[2] / "plugins" / "nrp-legacy" / "tests" / "corpus"
CART = (Path(__file__).parent / "files" / "cart.urdf").read_text()

BOMB = "".join(f'<!ENTITY x{n} "{f"&x{n - 1};" * 10}">' for n in range(1, 12))
ATTACKS = {
    "entities that grow": f'<!DOCTYPE a [<!ENTITY x0 "lol">{BOMB}]>',
    "a file of the machine": '<!DOCTYPE a [<!ENTITY x11 SYSTEM "file:///etc/hostname">]>',
    "an address": '<!DOCTYPE a [<!ENTITY x11 SYSTEM "http://127.0.0.1:1/x">]>',
    "a document type elsewhere": '<!DOCTYPE a SYSTEM "http://127.0.0.1:1/a.dtd">',
    "parameter entities": '<!DOCTYPE a [<!ENTITY % x11 SYSTEM "file:///etc/hostname"> %x11;]>',
}
FILES = {
    "robot": ("husky.sdf", "experiment.yaml"),
    "room": ("room.sdf", "experiment.yaml"),
    "model of a room": ("screen.sdf", "experiment.yaml"),
    "BIBI": ("listing2.bibi", "bibi.yaml"),
    "exc": ("husky_2017/experiment_configuration.exc", "husky_2017/experiment_configuration.exc"),
    "old BIBI": ("husky_2017/bibi_configuration.bibi", "husky_2017/experiment_configuration.exc"),
    "URDF": ("cart.urdf", "experiment.yaml"),
    "xacro": ("cart.xacro", "experiment.yaml"),
    "file that xacro includes": ("wheels.xacro", "experiment.yaml"),
    "MJCF": ("cart.xml", "experiment.yaml"),
}
XACRO = (
    '<robot name="cart" xmlns:xacro="http://ros.org/xacro"><xacro:include filename="wheels.xacro"/></robot>'
)
WHEELS = (
    '<robot xmlns:xacro="http://ros.org/xacro"><link name="base"><inertial><mass value="1"/>'
    '<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link></robot>'
)
MJCF = '<mujoco><worldbody><body><freejoint/><geom size="0.1"/></body></worldbody></mujoco>'
BODIES = {
    "xacro": "cart.xacro",
    "file that xacro includes": "cart.xacro",
    "URDF": "cart.urdf",
    "MJCF": "cart.xml",
}


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """All experiments and bodies of these tests in one folder."""
    shutil.copytree(SHIPPED, tmp_path, dirs_exist_ok=True, ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copytree(CORPUS, tmp_path, dirs_exist_ok=True)
    written = {"cart.urdf": CART, "cart.xacro": XACRO, "wheels.xacro": WHEELS, "cart.xml": MJCF}
    for name, text in written.items():
        (tmp_path / name).write_text(text)
    return tmp_path


def prepared(folder: Path, kind: str, body: str | None = None) -> None:
    body = body or BODIES.get(kind)
    plain = ["transfer_functions=null", "events=null", "criteria=null"]
    robot = [] if body is None else [f"world.robots.husky.model={folder / body}", *plain]
    models = [f"models=[{folder / 'models'}]"] if kind in ("exc", "old BIBI") else []
    prepare(load_experiment(str(folder / FILES[kind][1]), [*robot, *models]))


@pytest.mark.one_of(8)
@pytest.mark.parametrize("kind", FILES)
def test_entities_and_document_types_are_refused(folder: Path, kind: str) -> None:
    path = folder / FILES[kind][0]
    prepared(folder, kind)
    text, secret = path.read_text(), Path("/etc/hostname").read_text().strip()
    start = text.index("?>") + 2 if text.startswith("<?xml") else 0
    end = text.rindex("</")
    for attack in ATTACKS.values():
        path.write_text(f"{text[:start]}{attack}{text[start:end]}&x11;{text[end:]}")
        with limits(), pytest.raises(NrpError) as refused:
            prepared(folder, kind)
        said = str(refused.value).replace(str(folder), "")
        assert len(said) < 1000
        assert secret not in said


ARCHIVES = {
    "../outside.sdf": (b"<sdf/>", 0, "would be written outside"),
    "a/../../outside.sdf": (b"<sdf/>", 0, "would be written outside"),
    "/tmp/outside.sdf": (b"<sdf/>", 0, "would be written outside"),
    "..\\outside.sdf": (b"<sdf/>", 0, "would be written outside"),
    "C:\\outside.sdf": (b"<sdf/>", 0, "would be written outside"),
    "link": (b"/etc", stat.S_IFLNK | 0o777, "is a symbolic link"),
    "large": (bytes(20_000_000), 0, "of nearly nothing"),
}


@pytest.mark.parametrize("name", ARCHIVES)
def test_an_archive_that_reaches_outside_or_explodes_is_refused(folder: Path, name: str) -> None:
    content, mode, said = ARCHIVES[name]
    before = {path for path in folder.rglob("*") if path.name != "cart.zip"}
    with zipfile.ZipFile(folder / "cart.zip", "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("model.sdf", (folder / "husky.sdf").read_bytes())
        entry = zipfile.ZipInfo(name)
        entry.external_attr, entry.compress_type = mode << 16, zipfile.ZIP_DEFLATED
        archive.writestr(entry, content)
    with limits(), pytest.raises(NrpError, match=said):
        prepared(folder, "robot", "cart.zip")
    assert {path for path in folder.rglob("*") if path.name != "cart.zip"} == before


LISTENERS = """
import json, os, sys
from pathlib import Path
from nrp_core.experiment.running.run import Run

bound = []
sys.addaudithook(lambda event, args: bound.append(args[1]) if event == "socket.bind" else None)

def listening():
    own = {os.readlink(f"/proc/self/fd/{n}") for n in os.listdir("/proc/self/fd") if n.isdigit()
           and os.path.exists(f"/proc/self/fd/{n}") or os.path.islink(f"/proc/self/fd/{n}")}
    rows = [row.split() for table in ("tcp", "tcp6", "udp", "udp6")
            for row in Path(f"/proc/self/net/{table}").read_text().splitlines()[1:]]
    return [row[1] for row in rows if f"socket:[{row[9]}]" in own]

seen, finish = [], Run.result
def result(self):
    seen.extend(listening())
    return finish(self)
Run.result = result
from nrp_core.cli.app import run_app
code = run_app(sys.argv[1:])
print(json.dumps({"code": code, "bound": [str(one) for one in bound], "listening": seen}), file=sys.stderr)
"""


def test_a_run_that_is_recorded_and_controlled_opens_no_network_address(tmp_path: Path) -> None:
    path = tmp_path / "run.sock"
    command = [
        *(sys.executable, "-c", LISTENERS, "run", "braitenberg_husky", "--until", "0.2s"),
        *("--record", str(tmp_path / "recording"), "--control", str(path)),
        *("-s", "world.options.image_scale=0.05", "--json"),
    ]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=300, env=os.environ)
    found = json.loads(done.stderr.splitlines()[-1])
    assert found == {"code": 0, "bound": [f"{path}~"], "listening": []}, done.stdout  # named when it listens
