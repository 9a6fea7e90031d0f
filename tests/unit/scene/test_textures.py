"""Images on meshes and shapes reach viewers and digests; scenes have their mean colour."""

from __future__ import annotations

import io
import json
import shutil
from contextlib import ExitStack
from pathlib import Path

import cv2
import numpy as np
import pytest

from nrp_core._support.arrays import FloatArray
from nrp_core.messages.foxglove_msgs import ModelPrimitive
from nrp_core.recording.layout import MESH_TYPE, TEXTURED_TYPE, WORLD_FRAME
from nrp_core.recording.reading.shapes import RecordedScene
from nrp_core.recording.video.views import Stage, look_at
from nrp_core.recording.writing.frames import Frames
from nrp_core.recording.writing.scenery import scene_update, shown_visuals
from nrp_core.scene.meshes import mesh_pieces
from nrp_core.scene.meshes.convert import Wanted
from nrp_core.scene.meshes.gltf import MAX_SIDE_PX, glb
from nrp_core.scene.meshes.stl import read_coordinates, read_stl
from nrp_core.scene.meshes.triangles import mapped_triangles
from nrp_core.scene.model import Box, Capsule, Cylinder, Model, Plane, Scene, Sphere
from nrp_core.scene.rigid import Pose
from nrp_core.scene.sdf import read_model
from nrp_core.world.render.shaded import ShadedView

QUADRANTS = np.array([[(255, 0, 0), (0, 255, 0)], [(0, 0, 255), (255, 255, 255)]], np.uint8)
"""Blue and green above red and white, as OpenCV has them."""
PLACES = [(0, 0), (1, 0), (1, 1), (0, 1)]
SQUARE = """mtllib a.mtl\nusemtl poster\nv 0 0 0\nv 2 0 0\nv 2 0 2\nv 0 0 2
vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"""


@pytest.fixture
def home(tmp_path: Path) -> Path:
    cv2.imwrite(str(tmp_path / "poster.png"), cv2.resize(QUADRANTS, (8, 8), interpolation=cv2.INTER_NEAREST))
    (tmp_path / "a.mtl").write_text("newmtl poster\nmap_Kd poster.png\n")
    return tmp_path


def obj(faces: str) -> bytes:
    return f"{SQUARE}{faces}\n".encode()


def dae() -> bytes:
    """The same square, as pycollada writes it."""
    from collada import Collada, material, scene, source
    from collada.geometry import Geometry

    document = Collada()
    image = material.CImage("image", "poster.png")
    surface = material.Surface("surface", image)
    sampler = material.Sampler2D("sampler", surface)
    skin = material.Effect("skin", [surface, sampler], "lambert", diffuse=material.Map(sampler, "UV"))
    poster = material.Material("poster", "poster", skin)
    document.images.append(image)
    document.effects.append(skin)
    document.materials.append(poster)
    corners = np.array([(0, 0, 0), (2, 0, 0), (2, 0, 2), (0, 0, 2)], float)
    points = source.FloatSource("points", corners.ravel(), ("X", "Y", "Z"))
    maps = source.FloatSource("maps", np.array(PLACES, float).ravel(), ("S", "T"))
    shape = Geometry(document, "square", "square", [points, maps])
    inputs = source.InputList()
    inputs.addInput(0, "VERTEX", "#points")
    inputs.addInput(1, "TEXCOORD", "#maps", set="0")
    faces = np.repeat([0, 1, 2, 0, 2, 3], 2)
    shape.primitives.append(shape.createTriangleSet(faces, inputs, "poster"))
    document.geometries.append(shape)
    bound = scene.GeometryNode(shape, [scene.MaterialNode("poster", poster, inputs=[])])
    room = scene.Scene("room", [scene.Node("node", children=[bound])])
    document.scenes.append(room)
    document.scene = room
    text = io.BytesIO()
    document.write(text)
    return text.getvalue()


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("a.obj", obj("f 1/1 2/2 3/3 4/4")),
        ("a.obj", obj("f -4/-4/1 -3/-3/1 -2/-2/1 -1/-1/1")),
        ("a.dae", dae()),
    ],
)
@pytest.mark.parametrize("form", ["colored", "whole"])
def test_corners_of_meshes_keep_their_places_in_the_image(
    home: Path, name: str, content: bytes, form: str
) -> None:
    (home / name).write_bytes(content)
    (piece,) = mesh_pieces(home / name, Wanted(form))  # type: ignore[arg-type]
    coordinates = read_coordinates(piece.path)
    assert coordinates is not None
    assert coordinates == pytest.approx(read_stl(piece.path)[..., [0, 2]] / 2)
    assert piece.image == (home / "poster.png" if form == "colored" else None)
    if form == "colored":
        assert piece.rgba == pytest.approx((0.5, 0.5, 0.5, 1))


@pytest.mark.parametrize("faces", ["f 1 2 3 4", "f 1/1 2 3/3 4", "f 1//1 2//1 3//1", "f 1/9 2/2 3/3"])
def test_a_mesh_without_a_place_for_each_corner_has_none(home: Path, faces: str) -> None:
    (home / "a.obj").write_bytes(obj(faces))
    (piece,) = mesh_pieces(home / "a.obj", Wanted("colored"))
    assert read_coordinates(piece.path) is None


@pytest.mark.parametrize("shape", [Box((1, 2, 3)), Plane((2, 4)), Sphere(2.0), Cylinder(0.5, 3.0)])
def test_an_image_is_upright_and_not_mirrored_on_each_shape(shape: Box | Plane | Sphere | Cylinder) -> None:
    mapped = mapped_triangles(shape)
    assert mapped is not None
    triangles, coordinates = mapped
    assert (coordinates.min(), coordinates.max()) == (0, 1)
    (a, b, c), (p, q, r) = triangles.swapaxes(0, 1), coordinates.swapaxes(0, 1)
    normals = np.cross(b - a, c - a)
    large = np.linalg.norm(normals, axis=1) > 1e-9
    assert (np.einsum("ij,ij->i", normals, triangles.mean(1))[large] >= 0).all(), "seen from outside"
    turns = (q - p)[:, 0] * (r - p)[:, 1] - (q - p)[:, 1] * (r - p)[:, 0]
    assert (turns[large] >= 0).all(), "mirrored"
    sides = large & (np.abs(normals[:, 2]) < 1e-9 * np.abs(normals).max())  # they stand upright
    rises = np.sign(triangles[sides][:, :, 2] - triangles[sides].mean(1)[:, 2:])
    assert (np.sign(coordinates[sides][:, :, 1] - coordinates[sides].mean(1)[:, 1:]) == rises).all()


def test_shapes_without_places_for_an_image_keep_its_mean_colour() -> None:
    assert mapped_triangles(Capsule(1.0, 2.0)) is None


def gltf(data: bytes) -> tuple[dict[str, object], list[bytes]]:
    """Return the document and the contents of its views, by the specification of glTF 2.0."""
    head = np.frombuffer(data[:20], "<u4")
    assert head[1] == 2
    assert head[2] == len(data)
    assert (data[:4], data[16:20]) == (b"glTF", b"JSON")
    text, rest = data[20 : 20 + head[3]], data[20 + head[3] :]
    assert rest[4:8] == b"BIN\0"
    document = json.loads(text)
    views = [rest[8 + view["byteOffset"] :][: view["byteLength"]] for view in document["bufferViews"]]
    return document, views


def test_the_file_for_viewers_is_gltf_with_the_image_and_turned_to_its_axes(home: Path) -> None:
    mapped = mapped_triangles(Plane((2, 4)))
    assert mapped is not None
    data = glb(mapped, home / "poster.png", (1, 0.5, 0))
    assert data is not None
    document, (positions, places, image) = gltf(data)
    assert image == (home / "poster.png").read_bytes()
    assert np.frombuffer(positions, "<f4").reshape(-1, 3) == pytest.approx(mapped[0].reshape(-1, 3))
    from_the_top = np.frombuffer(places, "<f4").reshape(-1, 2)
    assert from_the_top == pytest.approx(mapped[1].reshape(-1, 2) * (1, -1) + (0, 1))
    from scipy.spatial.transform import Rotation

    (node,) = document["nodes"]  # type: ignore[misc]
    turned = Rotation.from_quat(node["rotation"]).apply(np.eye(3))
    assert turned == pytest.approx(np.array([(0, 0, 1), (1, 0, 0), (0, 1, 0)])), "x is ahead, z is up"


def test_large_images_and_those_of_other_kinds_become_png(home: Path) -> None:
    cv2.imwrite(str(home / "large.bmp"), np.zeros((10, 2 * MAX_SIDE_PX, 3), np.uint8))
    mapped = mapped_triangles(Plane())
    assert mapped is not None
    data = glb(mapped, home / "large.bmp", (1, 1, 1))
    assert data is not None
    _, (*_, image) = gltf(data)
    assert cv2.imdecode(np.frombuffer(image, np.uint8), cv2.IMREAD_COLOR).shape == (5, MAX_SIDE_PX, 3)
    assert glb(mapped, home / "a.mtl", (1, 1, 1)) is None
    assert glb(mapped, home / "gone.png", (1, 1, 1)) is None


# -- from a model to a viewer

BOX = "<box><size>1 1 1</size></box>"
PBR = "<diffuse>1 0.5 1 1</diffuse><pbr><metal><albedo_map>poster.png</albedo_map></metal></pbr>"
SCRIPT = "<script><uri>file://poster.material</uri><name>Poster</name></script>"


def model_with(home: Path, geometry: str, material: str) -> Model:
    (home / "poster.material").write_text("material Poster\n{ texture_unit {\n texture poster.png\n} }")
    (home / "a.obj").write_bytes(obj("f 1/1 2/2 3/3 4/4"))
    look = f"<material>{material}</material>" if material else ""
    visual = f'<visual name="v"><geometry>{geometry}</geometry>{look}</visual>'
    link = f'<static>1</static><link name="base">{visual}</link>'
    (home / "thing.sdf").write_text(f'<sdf version="1.6"><model name="thing">{link}</model></sdf>')
    return read_model(home / "thing.sdf")


@pytest.mark.parametrize(
    ("geometry", "material", "tint"),
    [
        (BOX, PBR, (1, 0.5, 1)),
        (BOX, SCRIPT, (1, 1, 1)),
        ("<mesh><uri>a.obj</uri></mesh>", SCRIPT, (1, 1, 1)),
        ("<mesh><uri>a.obj</uri></mesh>", "", (1, 1, 1)),
    ],
)
def test_a_viewer_gets_the_image_until_the_visual_has_another_colour(
    home: Path, geometry: str, material: str, tint: tuple[float, float, float]
) -> None:
    model = model_with(home, geometry, material)
    (visual,) = model.links[0].visuals
    assert visual.rgba == pytest.approx([0.5 * part for part in tint] + [1])
    assert visual.texture is not None
    assert visual.texture.tint == tint
    scene = Scene((model,))
    (sent,) = models_of(scene, {})
    assert sent.media_type == TEXTURED_TYPE
    assert not sent.override_color
    document, _ = gltf(sent.data.tobytes())
    (skin,) = document["materials"]  # type: ignore[misc]
    factor = skin["pbrMetallicRoughness"]["baseColorFactor"]
    assert factor[0] == 1
    assert (factor[1] == 1) == (tint[1] == 1)
    painted = models_of(scene, {"thing/base/v": (1.0, 0.0, 0.0, 1.0)})
    assert [each.media_type for each in painted] == ([MESH_TYPE] if "mesh" in geometry else [])


@pytest.mark.parametrize(
    ("geometry", "material", "eye", "middle", "white"),
    [
        ("<mesh><uri>a.obj</uri></mesh>", "", (1, -1, 1), (1, 0, 1), (1, 1, 1)),
        ("<plane><size>1 1</size></plane>", PBR, (0, 0, 1), (0, 0, 0), (1, 0, 1)),
    ],
)
def test_videos_show_the_image(home: Path, geometry: str, material: str, eye, middle, white) -> None:
    recorded = RecordedScene()
    scene = Scene((model_with(home, geometry, material),))
    recorded.take(scene_update({}, shown_visuals(scene, Still(), {}), 0))
    with ExitStack() as kept:
        stage = Stage(recorded.shapes, kept)
        view = ShadedView(stage.mesh, 90, 90, vertical_fov=1.0)
        image = view.draw(stage.frames({}), look_at(eye, middle))
    bright = image > 0.75 * image.max(axis=2, keepdims=True)
    assert bright[30, [30, 60]].tolist() == [[0, 0, 1], [0, 1, 0]]
    assert bright[60, [30, 60]].tolist() == [[1, 0, 0], [*white]]


def test_the_digest_of_a_scene_depends_on_what_is_in_an_image_and_not_on_where_it_lies(home: Path) -> None:
    box, look = (
        "<box><size>1 1 1</size></box>",
        "<script><uri>poster.material</uri><name>Poster</name></script>",
    )
    there = home / "there"
    shutil.copytree(home, there)
    before, moved = (Scene((model_with(each, box, look),)) for each in (home, there))
    assert moved.models[0].links[0].visuals[0].texture is not None
    assert moved.digest == before.digest
    cv2.imwrite(
        str(there / "poster.png"), cv2.resize(QUADRANTS[::-1], (8, 8), interpolation=cv2.INTER_NEAREST)
    )
    assert Scene((model_with(there, box, look),)).digest != before.digest


class Still(Frames):
    """The frames of a scene in which nothing moves."""

    def place(self, model: str, link: str) -> tuple[str, Pose]:
        return WORLD_FRAME, Pose()

    def poses(self) -> FloatArray:
        return np.empty((0, 7))


def models_of(scene: Scene, colors: dict[str, tuple[float, float, float, float]]) -> list[ModelPrimitive]:
    (entity,) = scene_update({}, shown_visuals(scene, Still(), colors), 0).entities
    return entity.models
