"""Files that announce sizes that fill the memory are refused before anything is allocated."""

import struct
import zipfile
import zlib
from pathlib import Path

import pytest
from golden import Golden
from nrp_world_mujoco.announced_sizes import check_sizes
from nrp_world_mujoco.mjcf import read_mjcf

from nrp_core.archives import unpack
from nrp_core.errors import ExperimentError, SceneError
from nrp_core.scene.meshes.shapes import heights_in
from nrp_core.scene.meshes.stl import mean_color

MJCF = {
    "hfield": (
        "<asset><hfield name='h' nrow='60000' ncol='60000' size='1 1 1 1'/></asset>"
        "<worldbody><geom type='hfield' hfield='h'/></worldbody>"
    ),
    "texture": "<asset><texture name='t' type='2d' builtin='flat' width='60000' height='60000'/></asset>",
    "flexcomp": (
        "<worldbody><body><flexcomp name='f' type='grid' count='400 400 400' spacing='.1 .1 .1' dim='3'/>"
        "</body></worldbody>"
    ),
    "replicate": "<worldbody>" + "<replicate count='1000'>" * 3 + "</replicate>" * 3 + "</worldbody>",
}


def test_a_cube_has_six_squares_unless_its_file_says_otherwise(tmp_path: Path) -> None:
    texture = "<mujoco><asset><texture name='t' type='cube' builtin='flat' width='{}'/></asset></mujoco>"
    (tmp_path / "robot.xml").write_text(texture.format(4000))
    with pytest.raises(SceneError, match="<texture>"):
        check_sizes(tmp_path / "robot.xml")
    (tmp_path / "robot.xml").write_text(texture.format(512))
    check_sizes(tmp_path / "robot.xml")


@pytest.mark.parametrize("element", MJCF)
def test_large_parts_of_mjcf_are_refused(element: str, tmp_path: Path, golden: Golden) -> None:
    (tmp_path / "part.xml").write_text(f"<mujoco>{MJCF[element]}</mujoco>")
    (tmp_path / "robot.xml").write_text("<mujoco><include file='part.xml'/></mujoco>")
    with golden.raises(SceneError, match=f"<{element}>") as caught:
        read_mjcf(tmp_path / "robot.xml")
    assert caught.value.path == tmp_path / "part.xml"


def header_only(width: int, height: int) -> bytes:
    """Return a PNG file that announces a size and holds one row."""

    def chunk(kind: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    head = chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0))
    return b"\x89PNG\r\n\x1a\n" + head + chunk(b"IDAT", zlib.compress(bytes(width + 1))) + chunk(b"IEND", b"")


def test_large_images_are_not_decoded() -> None:
    assert mean_color(header_only(20_000, 20_000)) is None
    with pytest.raises(ValueError, match="67 million pixels"):
        heights_in(header_only(20_000, 20_000))


def test_an_archive_of_many_files_of_nearly_nothing_is_refused(tmp_path: Path, golden: Golden) -> None:
    with zipfile.ZipFile(tmp_path / "many.zip", "w", zipfile.ZIP_DEFLATED) as packed:
        for number in range(4):
            packed.writestr(f"m/{number}", bytes(9_900_000))
    with golden.raises(ExperimentError, match="40 MB"):
        unpack(tmp_path / "many.zip")
