"""The images of a camera as they are sent."""

from __future__ import annotations

from nrp_core.recording.writing import encoding
from nrp_core.recording.writing.signals import CameraImages, RecordEntry
from nrp_core.world.messages.sensor_msgs import Image
from nrp_core.world.topics import Stamped


class WholeImages(CameraImages):
    """The images of one camera, uncompressed, unlike those in recordings."""

    def _entry(self, topic: str, stamped: Stamped) -> RecordEntry:
        parts = encoding.image(stamped.message, pack=False)
        return RecordEntry(stamped.t_ns, topic, Image, self._about, parts)
