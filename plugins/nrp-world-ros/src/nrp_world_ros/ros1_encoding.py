"""Messages as bytes: the encoding of ROS 1, for every message class.

The message classes have the fields of ROS 2. Additional fields of ROS 1 (``seq`` of a header) and other
spellings (``K`` of a camera's optics) are converted here; a type with other differences is refused.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from hashlib import md5
from types import SimpleNamespace
from typing import Any

from nrp_core.messages.cdr import Codec
from rosbags.typesys import Stores

_HEADER = "std_msgs/msg/Header"
_OTHERWISE = {
    "sensor_msgs/msg/CameraInfo": {"D": "d", "K": "k", "R": "r", "P": "p"},
    "cle_ros_msgs/msg/SpikeEvent": {
        "simulationTime": "simulation_time", "neuronCount": "neuron_count", "monitorName": "monitor_name",
        "populationLabel": "population_label",
    },
    "cle_ros_msgs/msg/SpikeRate": {"simulationTime": "simulation_time", "monitorName": "monitor_name"},
}  # fmt: skip
"""Names of fields in our classes that differ in ROS 1."""
_LATER = {"sensor_msgs/msg/Range": ("variance",)}
"""The last fields of our classes that ROS 1 does not have; they are not sent."""


class Ros1Codec(Codec):
    """Encodes and decodes messages as ROS 1 does."""

    _known_types = Stores.ROS1_NOETIC

    def definition(self, name: str) -> str:
        """Return the text that defines a type, in the format of ROS 1."""
        return self._store.generate_msgdef(name, ros_version=1)[0]

    def md5(self, name: str) -> str:
        """Return the checksum by which ROS 1 compares types."""
        return self._store.generate_msgdef(name, ros_version=1)[1]

    def service_md5(self, request: str, response: str) -> str:
        """Return the checksum by which ROS 1 compares services."""
        return md5((self._hash_definition(request) + self._hash_definition(response)).encode()).hexdigest()

    def _hash_definition(self, name: str) -> str:
        """Return the definition of a type, with the checksums of the types in it instead of their names."""
        own, _, _ = self.definition(name).partition("=" * 80)
        lines = [line.partition(" ") for line in own.strip().splitlines()]
        return "\n".join(
            f"{self.md5(kind.partition('[')[0].replace('/', '/msg/')) if '/' in kind else kind} {rest}"
            for kind, _, rest in lines
        )

    def _fast(self, name: str) -> Callable[[Any], bytes] | None:
        return None

    def _serialize(self, message: Any, name: str) -> memoryview:
        return self._store.serialize_ros1(message, name)

    def _deserialize(self, data: bytes | memoryview, name: str) -> Any:
        return self._store.deserialize_ros1(data, name)

    def _renamed(self, name: str) -> Mapping[str, str]:
        return _OTHERWISE.get(name, {})

    def _field_names_of(self, name: str) -> list[str]:
        names = [field for field in super()._field_names_of(name) if (name, field) != (_HEADER, "seq")]
        return [*names, *_LATER.get(name, ())]

    def _decode_into(self, name: str, cls: type) -> None:
        if name == _HEADER:
            self._store.types[name] = lambda _seq, *fields: cls(*fields)  # type: ignore[assignment]
        else:
            super()._decode_into(name, cls)

    def _prepare_of(self, name: str) -> Callable[[Any], Any] | None:
        if name == _HEADER:
            return lambda header: SimpleNamespace(seq=0, stamp=header.stamp, frame_id=header.frame_id)
        return super()._prepare_of(name)
