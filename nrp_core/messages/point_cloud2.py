"""Convert point clouds of ROS to and from NumPy arrays.

Experiment files import it as in ROS 1, ``sensor_msgs.point_cloud2``, or as in ROS 2, ``sensor_msgs_py``.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
import numpy.typing as npt

from nrp_core.errors import did_you_mean
from nrp_core.messages.sensor_msgs import PointCloud2, PointField
from nrp_core.messages.std_msgs import Header

_FORMATS = {
    PointField.INT8: "i1", PointField.UINT8: "u1", PointField.INT16: "i2", PointField.UINT16: "u2",
    PointField.INT32: "i4", PointField.UINT32: "u4", PointField.FLOAT32: "f4", PointField.FLOAT64: "f8",
}  # fmt: skip
_DATATYPES = {np.dtype(name): datatype for datatype, name in _FORMATS.items()}


def read_points(
    cloud: PointCloud2, field_names: Iterable[str] | None = None, skip_nans: bool = False
) -> npt.NDArray[np.void]:
    """Return the points of a cloud, row by row, as a structured array; ``for x, y, z in ...`` reads it, too.

    Args:
        cloud: the message.
        field_names: which fields, by default all.
        skip_nans: leave out points with a NaN in a field.

    Raises:
        ValueError: the field does not exist, or the data are too short for the points.
    """
    names = [field.name for field in cloud.fields]
    order = ">" if cloud.is_bigendian else "<"
    kinds = [
        (order + _FORMATS[field.datatype], (field.count,) if field.count > 1 else ())
        for field in cloud.fields
    ]
    offsets = [field.offset for field in cloud.fields]
    layout = np.dtype({"names": names, "formats": kinds, "offsets": offsets, "itemsize": cloud.point_step})
    points = np.frombuffer(cloud.data, layout, cloud.height * cloud.width)
    wanted = names if field_names is None else list(field_names)
    for name in wanted:
        if name not in names:
            raise ValueError(f"the points have no field '{name}'{did_you_mean(name, names)}")
    points = points[wanted]
    if skip_nans:
        numbers = [np.isfinite(points[name]).reshape(len(points), -1).all(axis=1) for name in wanted]
        points = points[np.logical_and.reduce(numbers)]
    return points


def create_cloud(header: Header, points: npt.NDArray[np.void]) -> PointCloud2:
    """Return a cloud of points.

    Args:
        header: their time and frame.
        points: a structured array of plain fields, shape ``(width,)`` or ``(height, width)``.
    """
    rows = np.atleast_2d(points)
    described: dict[str, tuple[Any, ...]] = dict(rows.dtype.fields or {})
    fields = [PointField(name, at, _DATATYPES[kind], 1) for name, (kind, at) in described.items()]
    height, width = rows.shape
    step = rows.dtype.itemsize
    data = np.frombuffer(rows.tobytes(), np.uint8)
    return PointCloud2(header, height, width, fields, False, step, step * width, data, False)
