"""Clouds of points hold what was put into them, as any program of ROS would read it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest
from golden import Golden
from hypothesis import given
from hypothesis.extra.numpy import array_shapes, arrays

from nrp_core.dsl.loading import file_scope
from nrp_core.messages.point_cloud2 import create_cloud, read_points
from nrp_core.messages.sensor_msgs import PointCloud2, PointField
from nrp_core.messages.std_msgs import Header

POINT = np.dtype([("x", "<f4"), ("ring", "<u2"), ("y", "<f8"), ("level", "|i1")])


@given(arrays(POINT, array_shapes(min_dims=1, max_dims=2, min_side=0, max_side=5)))
def test_points_survive_a_cloud(points: np.ndarray) -> None:
    cloud = create_cloud(Header(), points)
    assert len(cloud.data) == cloud.row_step * cloud.height == cloud.point_step * cloud.height * cloud.width
    assert read_points(cloud).tobytes() == points.tobytes()


def big_endian(values: Sequence[float]) -> PointCloud2:
    fields = [PointField("x", 4, PointField.FLOAT32, 1), PointField("uv", 8, PointField.INT16, 2)]
    data = b"".join(
        bytes(4) + np.array(x, ">f4").tobytes() + np.array([1, -2], ">i2").tobytes() for x in values
    )
    return PointCloud2(Header(), 1, len(values), fields, True, 12, 36, np.frombuffer(data, np.uint8), False)


def test_clouds_of_others_are_read_with_gaps_several_numbers_and_either_byte_order() -> None:
    points = read_points(big_endian([1.5, np.nan, -3.0]), skip_nans=True)
    assert points["x"].tolist() == [1.5, -3.0]
    assert points["uv"].tolist() == [[1, -2]] * 2


def test_a_missing_field_is_named(golden: Golden) -> None:
    with golden.raises(ValueError, match="'ux'.*'x'"):
        read_points(big_endian([1.0]), ["ux"])


@pytest.mark.parametrize("module", ["sensor_msgs", "sensor_msgs_py"])
def test_files_of_experiments_read_clouds_as_with_ros(module: str, tmp_path) -> None:
    file = tmp_path / "file.py"
    file.write_text(
        f"import {module}.point_cloud2 as pc2\nfrom {module} import point_cloud2\n"
        "assert pc2 is point_cloud2\n"
        "def xs(cloud):\n    return [x for (x,) in pc2.read_points(cloud, field_names=('x',))]\n"
    )
    framework = type(np)("framework")
    assert file_scope(framework).run(file).xs(big_endian([1.0, 2.0])) == [1.0, 2.0]
