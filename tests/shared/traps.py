"""A folder of files that execute code, or read or write elsewhere, if a program opens them carelessly.

``python -P traps.py < COMMANDS`` runs command lines, one JSON list a line, in the working directory, and
prints for each which traps it sprang. A trap that is sprung makes a file of its name in ``MARKS``.
"""

from __future__ import annotations

import json
import os
import pickle
import sys
import zipfile
from collections.abc import Iterator
from html import escape
from pathlib import Path

MARKS = "TRAPS_MARKS"
"""The environment variable with the folder of marks."""
MODULES = (
    "base64", "select", "json", "socket", "random", "hashlib", "typing", "string", "token", "sitecustomize",
    "usercustomize", "conftest", "yaml", "numpy", "lxml", "typer", "mujoco", "cv2", "matplotlib",
    "nrp_plugin",
)  # fmt: skip
PIPES = (
    ".yaml", ".py", ".urdf", ".xacro", ".sdf", ".xml", ".zip", ".bibi", ".exc", ".json", ".nrpnet", ".nir",
    ".pkl", ".mcap", ".csv", ".ipynb", "",
)  # fmt: skip
"""Suffixes of pipes ``waiting``, in which nobody writes."""
MASS = '<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>'


def python(name: str) -> str:
    """Return a line of Python that leaves a mark."""
    return f"__import__('os').close(__import__('os').open({mark(name)!r}, 65))"


def mark(name: str) -> str:
    return str(Path(os.environ[MARKS]) / name)


class Pickled:
    """Leaves a mark when it is unpickled."""

    def __init__(self, name: str) -> None:
        self._name = name

    def __reduce__(self) -> tuple[object, tuple[str]]:
        return eval, (python(self._name),)


def finder(name: str) -> str:
    """Return an expression that finds a way to start a program without a name of a builtin."""
    found = "[c for c in ().__class__.__base__.__subclasses__() if c.__name__ == 'Popen'][0]"
    return f"(lambda: {found}(['touch', {mark(name)!r}]).wait())()"


def xacro(name: str) -> str:
    value = escape(f"${{{finder(name)}}}")
    return (
        '<robot xmlns:xacro="http://www.ros.org/wiki/xacro" name="r">'
        f'<xacro:property name="p" value="{value}"/><link name="x${{p}}">{MASS}</link></robot>'
    )


BRAIN = """
import nrp_core.pynn as sim
sim.setup(timestep=0.1)
eyes = sim.Population(2, sim.IF_curr_exp(tau_refrac=2.0), label="eyes")
wheels = sim.Population(2, sim.IF_curr_exp(tau_refrac=2.0), label="wheels")
"""
FUNCTIONS = """
import hbp_nrp_client.tf_framework as nrp
from geometry_msgs.msg import Twist, Vector3

@nrp.MapSpikeSink("left", nrp.brain.wheels[0], nrp.population_rate)
@nrp.Neuron2Robot(nrp.Topic("/husky/cmd_vel", Twist))
def drive(t, left):
    return Twist(Vector3(0.1, 0, 0), Vector3(0, 0, 0))
"""
EXPERIMENT = """
name: "{{ ''.__class__.__mro__ }}"
extends: braitenberg_husky/no_red
duration: 0.04 s
brain: {model: brain.py, populations: null}
transfer_functions: [functions.py]
criteria: null
"""
EXC = (
    '<ExD xmlns="http://schemas.humanbrainproject.eu/SP10/2014/ExDConfig"><name>T</name><timeout>0.1</timeout>'
    '<environmentModel src="../../../../etc/hostname"/><bibiConf src="old.bibi"/></ExD>'
)
BIBI = (
    '<bibi xmlns="http://schemas.humanbrainproject.eu/SP10/2014/BIBI" '
    'xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance"><brainModel><file>old_brain.py</file></brainModel>'
    '<transferFunction xsi:type="PythonTransferFunction">{}\n'
    '@nrp.Robot2Neuron()\ndef note(t):\n    print "it"\n'
    "</transferFunction></bibi>"
)


def files() -> Iterator[tuple[str, str | bytes]]:
    """Yield the names and contents of the traps."""
    for name in MODULES:
        yield f"{name}.py", python(f"module_{name}")
    yield "evil.pth", f"import os; {python('pth')}"
    yield "pytest.ini", "[pytest]\naddopts = -p nrp_plugin\n"
    yield "pyproject.toml", '[tool.pytest.ini_options]\naddopts = "-p nrp_plugin"\n'
    yield "matplotlibrc", "backend: module://nrp_plugin\nanimation.ffmpeg_path: ./ffmpeg\n"
    yield ".numba_config.yaml", "!!python/object/apply:os.system [touch x]\n"
    yield "ffmpeg", f"#!/bin/sh\ntouch {mark('program_ffmpeg')}\n"
    for name, text in (("brain", BRAIN), ("functions", FUNCTIONS)):  # they go on if they may not leave a mark
        yield f"{name}.py", f"try:\n    {python(name)}\nexcept OSError:\n    pass\n{text}"
    yield "experiment.yaml", EXPERIMENT
    yield "tagged.yaml", f'!!python/object/apply:os.system ["touch {mark("yaml_tag")}"]\n'
    yield "robots.yaml", f"{EXPERIMENT}world: {{robots: {{husky: {{model: robot.urdf.xacro}}}}}}\n"
    yield "pickled.yaml", EXPERIMENT.replace("brain.py", "network.pkl")
    yield "robot.urdf.xacro", xacro("xacro")
    yield "robot.urdf", xacro("urdf")
    yield "robot.xml", xacro("xml")
    yield "evaluated.xacro", xacro("unused").replace("${p}", f"$(eval {escape(python('xacro_eval'))})")
    world = '<sdf version="1.7"><world name="w">{}</world></sdf>'
    yield "world.sdf", world.format("<include><uri>robot.urdf.xacro</uri></include>")
    yield "pipes.sdf", world.format("<include><uri>waiting.urdf</uri></include>")
    yield "pipes.xacro", '<robot xmlns:xacro="x" name="r"><xacro:include filename="waiting.xml"/></robot>'
    yield "pipes.yaml", EXPERIMENT.replace("brain.py", "waiting.py")
    yield "plugin.sdf", world.format(f'<plugin name="p" filename="{mark("library")}"/>')
    yield "entity.sdf", '<!DOCTYPE a [<!ENTITY x SYSTEM "file:///etc/hostname">]>' + world.format("&x;")
    yield "model.xml", '<mujoco><extension><plugin plugin="nrp.evil"/></extension><worldbody/></mujoco>'
    yield "network.pkl", pickle.dumps(Pickled("pickle"))
    yield "network.npy", b"\x93NUMPY\x01\x00v\x00" + pickle.dumps(Pickled("npy"))
    yield "network.nrpnet", pickle.dumps(Pickled("nrpnet"))
    yield "network.json", json.dumps({"components": {"biophysical_neuron_models_dir": "network.pkl"}})
    yield "cells.nestml", f"model evil:\n  state:\n    x real = {python('nestml')}\n"
    yield "notebook.ipynb", json.dumps({"cells": [{"cell_type": "code", "source": [python("notebook")]}]})
    yield "old.exc", EXC
    yield "old.bibi", BIBI.format(python("bibi"))
    yield "old_brain.py", python("old_brain") + "\nfrom hbp_nrp_cle.brainsim import simulator as sim\n"
    yield "machine.exd", python("machine")
    yield (
        "start.launch",
        f'<launch><node pkg="x" type="y" name="z" launch-prefix="touch {mark("launch")}"/></launch>',
    )
    engine = {
        "EngineType": "python_json", "EngineName": "e", "PythonFileName": "engine.py",
        "EngineProcCmd": f"touch {mark('command')}", "EngineLaunchCommand": f"touch {mark('launch_command')}",
    }  # fmt: skip
    function = {"Name": "f", "FileName": "v4_function.py"}
    yield (
        "simulation_config.json",
        json.dumps(
            {"SimulationName": "t", "EngineConfigs": [engine], "DataPackProcessingFunctions": [function]}
        ),
    )
    yield "engine.py", python("v4_engine")
    yield "v4_function.py", python("v4_function")
    yield "sweep.yaml", "experiment: experiment.yaml\ngrid: {seed: [1]}\n"
    yield "template.html.j2", "{{ cycler.__init__.__globals__.os.system('touch x') }}"
    yield "edges.csv", "pre,post,weight\n=cmd|'/bin/touch x'!A0,b,1\n"
    yield "mesh.dae", '<!DOCTYPE a [<!ENTITY x SYSTEM "file:///etc/hostname">]><COLLADA>&x;</COLLADA>'
    yield "mesh.stl", b"\0" * 80 + b"\xff\xff\xff\xff"
    yield "image.png", b"\x89PNG\r\n\x1a\n" + b"\0" * 64


def lay(folder: Path) -> None:
    """Make the traps in a folder."""
    for name, contents in files():
        path = folder / name
        path.write_bytes(contents.encode() if isinstance(contents, str) else contents)
    (folder / "ffmpeg").chmod(0o755)
    (folder / "link.yaml").symlink_to("/etc/hostname")
    (folder / "beside").symlink_to("/etc")
    (folder / "again").symlink_to(".")
    (folder / "endless.urdf").symlink_to("/dev/zero")
    (folder / "around.sdf").symlink_to("around.sdf")
    for suffix in PIPES:
        os.mkfifo(folder / f"waiting{suffix}")
    with zipfile.ZipFile(folder / "robot.zip", "w") as packed:
        packed.writestr(f"../../../../../../../../..{mark('zip')}", "x")
        packed.writestr("robot.urdf", xacro("zipped"))


def main() -> None:
    """Run the command lines of standard input."""
    from nrp_core.cli.app import run_app

    folder = Path(os.environ[MARKS])
    answers = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)
    for line in sys.stdin:
        try:
            code: object = run_app(json.loads(line))
        except SystemExit as left:
            code = left.code
        sprung = sorted(path.name for path in folder.iterdir())
        for name in sprung:
            (folder / name).unlink()
        answers.write(json.dumps([code, sprung]) + "\n")
        answers.flush()


if __name__ == "__main__":
    main()
