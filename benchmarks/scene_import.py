"""How long it takes to import a room of many models with meshes: reading it, and opening it in each engine.

The room is generated: most of its models are included from folders of their own, with a mesh in STL, OBJ or
Collada for the visual and the collision, a few are written in place. ``cold`` is the first import, which
converts the meshes; ``warm`` every later one. CPU time, best of several rounds.

    python benchmarks/scene_import.py
    python benchmarks/scene_import.py --models 75 --rounds 5 --json
"""

from __future__ import annotations

import argparse
import json
import os
import time
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from conditions import print_conditions

KINDS = ("stl", "obj", "dae")
PLACE = 0.1  # share of the models that are written in place
FINENESS = 40
"""Rings of a mesh, a surface of revolution; it has twice as many corners around."""

INCLUDED = """<sdf version="1.9"><model name="thing{i}"><static>true</static><link name="body">
  <visual name="skin"><geometry><mesh><uri>model://thing{i}/meshes/thing.{kind}</uri></mesh></geometry></visual>
  <collision name="hull"><geometry><mesh><uri>model://thing{i}/meshes/thing.{kind}</uri></mesh></geometry>
    <surface><friction><ode><mu>0.8</mu><mu2>0.8</mu2></ode></friction></surface></collision>
</link></model></sdf>"""
WRITTEN = """<model name="thing{i}"><static>true</static><pose>{x} {y} 0.25 0 0 0.3</pose><link name="body">
  <visual name="skin"><geometry><box><size>0.5 0.5 0.5</size></box></geometry>
    <material><script><name>Gazebo/Blue</name></script></material></visual>
  <collision name="hull"><geometry><box><size>0.5 0.5 0.5</size></box></geometry></collision>
</link></model>"""
COLLADA = """<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
  <asset><created>2020-01-01T00:00:00</created><modified>2020-01-01T00:00:00</modified></asset>
  <library_geometries><geometry id="g"><mesh>
    <source id="p"><float_array id="n" count="{numbers}">{points}</float_array><technique_common>
      <accessor source="#n" count="{count}" stride="3"><param name="X" type="float"/>
        <param name="Y" type="float"/>
        <param name="Z" type="float"/></accessor></technique_common></source>
    <vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
    <triangles count="{triangles}"><input semantic="VERTEX" source="#v" offset="0"/><p>{faces}</p></triangles>
  </mesh></geometry></library_geometries>
  <library_visual_scenes><visual_scene id="s"><node id="thing">
    <instance_geometry url="#g"/></node></visual_scene>
  </library_visual_scenes><scene><instance_visual_scene url="#s"/></scene></COLLADA>"""


def vase(seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the vertices and triangles of a surface of revolution."""
    random = np.random.Generator(np.random.Philox(seed))
    heights = np.linspace(0, 0.8, FINENESS)
    radii = 0.05 + 0.2 * np.abs(np.sin(np.cumsum(random.uniform(0, 0.3, FINENESS))))
    around = 2 * FINENESS
    angles = np.linspace(0, 2 * np.pi, around, endpoint=False)
    x, y = np.outer(radii, np.cos(angles)), np.outer(radii, np.sin(angles))
    vertices = np.stack([x, y, np.repeat(heights[:, None], around, axis=1)], axis=2).reshape(-1, 3)
    low = (np.arange(FINENESS - 1)[:, None] * around + np.arange(around)).ravel()
    turned = (np.arange(FINENESS - 1)[:, None] * around + (np.arange(around) + 1) % around).ravel()
    faces = np.concatenate([
        np.stack([low, turned, turned + around], axis=1),
        np.stack([low, turned + around, low + around], axis=1),
    ])  # fmt: skip
    return vertices, faces


def write_mesh(path: Path, vertices: np.ndarray, faces: np.ndarray) -> None:
    """Write a mesh in the format of its suffix."""
    match path.suffix:
        case ".stl":
            from nrp_core.world.scene.meshes.stl import write_stl

            write_stl(path, vertices[faces])
        case ".obj":
            rows = ["v {:.6f} {:.6f} {:.6f}".format(*vertex) for vertex in vertices]
            rows += ["f {} {} {}".format(*face) for face in faces + 1]
            path.write_text("\n".join(rows))
        case _:
            points = " ".join(f"{number:.6f}" for number in vertices.ravel())
            indices = " ".join(map(str, faces.ravel()))
            path.write_text(
                COLLADA.format(
                    numbers=vertices.size,
                    count=len(vertices),
                    points=points,
                    triangles=len(faces),
                    faces=indices,
                )
            )


def write_room(folder: Path, models: int) -> Path:
    """Write a room and the models that it includes; return its file."""
    things = []
    for i in range(models):
        x, y = 1.2 * (i % 9), 1.2 * (i // 9)
        if i < PLACE * models:
            things.append(WRITTEN.format(i=i, x=x, y=y))
            continue
        meshes = folder / f"thing{i}" / "meshes"
        meshes.mkdir(parents=True)
        kind = KINDS[i % len(KINDS)]
        write_mesh(meshes / f"thing.{kind}", *vase(i))
        (meshes.parent / "model.sdf").write_text(INCLUDED.format(i=i, kind=kind))
        (meshes.parent / "model.config").write_text('<model><sdf version="1.9">model.sdf</sdf></model>')
        things.append(f"<include><uri>model://thing{i}</uri><pose>{x} {y} 0 0 0 0</pose></include>")
    room = folder / "room.sdf"
    room.write_text(f'<sdf version="1.9"><world name="room">{"".join(things)}</world></sdf>')
    return room


def cpu_ms(work: Callable[[], object]) -> float:
    start = time.process_time()
    work()
    return 1000 * (time.process_time() - start)


def measure(models: int, rounds: int) -> dict[str, float]:
    """Return CPU milliseconds of each kind of import."""
    from nrp_core.world.backends import worlds
    from nrp_core.world.interface import WorldBackend
    from nrp_core.world.scene.sdf import read_scene

    with TemporaryDirectory() as folder:
        os.environ["XDG_CACHE_HOME"] = str(Path(folder) / "cache")
        room = write_room(Path(folder), models)
        result = {"read, cold": cpu_ms(lambda: read_scene(room))}
        result["read, warm"] = min(cpu_ms(lambda: read_scene(room)) for _ in range(rounds))
        scene = read_scene(room)
        if scene.warnings or len(scene.models) != models:
            raise RuntimeError(
                f"the room that was read differs from the room that was written: {scene.warnings}"
            )
        for name in ("mujoco", "pybullet"):
            backend = worlds().load(name)

            def opened(backend: WorldBackend = backend) -> None:
                with backend.open(scene, seed=1, options=backend.options()):
                    pass

            result[f"open in {name}"] = min(cpu_ms(opened) for _ in range(rounds))
    return result


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--models", type=int, default=75)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--json", action="store_true")
    arguments = parser.parse_args()
    print_conditions()
    result = measure(arguments.models, arguments.rounds)
    if arguments.json:
        print(json.dumps({"models": arguments.models, "cpu_ms": result}, indent=2))
        return
    print(f"A room of {arguments.models} models, CPU time in ms")
    for what, milliseconds in result.items():
        print(f"  {what:<20}{milliseconds:8.0f}")


if __name__ == "__main__":
    main()
