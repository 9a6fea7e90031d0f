"""Recordings: a folder with the experiment's files, data about the run, and every message in an MCAP file.

The names here are those that read, compare and replay recordings; each is imported when it is first used.
"""

from nrp_core._support.lazy import lazily

TYPE_CHECKING = False  # type checkers know this name; importing typing would take 5 ms
if TYPE_CHECKING:
    from nrp_core._support.used_files import FilesRead as FilesRead
    from nrp_core.recording.export import Exporter as Exporter
    from nrp_core.recording.export.numbers import Numbers as Numbers
    from nrp_core.recording.export.numbers import Series as Series
    from nrp_core.recording.export.numbers import groups_of as groups_of
    from nrp_core.recording.folder.dependencies import Dependencies as Dependencies
    from nrp_core.recording.folder.dependencies import changes_since as changes_since
    from nrp_core.recording.folder.dependencies import dependencies as dependencies
    from nrp_core.recording.folder.recording_folder import RecordingFolder as RecordingFolder
    from nrp_core.recording.images import values_of as values_of
    from nrp_core.recording.layout import RUN_NAME as RUN_NAME
    from nrp_core.recording.layout import Images as Images
    from nrp_core.recording.layout import Role as Role
    from nrp_core.recording.reading.mcap_messages import RecordedTopic as RecordedTopic
    from nrp_core.recording.reading.steps import Comparison as Comparison
    from nrp_core.recording.reading.steps import Difference as Difference
    from nrp_core.recording.reading.steps import RecordedStep as RecordedStep
    from nrp_core.recording.reading.steps import nearest_quaternions as nearest_quaternions
    from nrp_core.recording.reading.steps import steps_of as steps_of
    from nrp_core.recording.reading.tables import numbers_in as numbers_in
    from nrp_core.recording.recording import Recording as Recording
    from nrp_core.recording.replay.recorded_world import with_recorded_brain as with_recorded_brain
    from nrp_core.recording.replay.recorded_world import with_recorded_world as with_recorded_world
    from nrp_core.recording.replay.replay import Replay as Replay
    from nrp_core.recording.replay.replay import ReplayRequest as ReplayRequest
    from nrp_core.recording.replay.replay import ReplayVerdict as ReplayVerdict
    from nrp_core.recording.sealing import file_digest as file_digest
    from nrp_core.recording.sealing import seal as seal
    from nrp_core.recording.writing.frames import SceneFrames as SceneFrames
    from nrp_core.recording.writing.muscles import MusclePaths as MusclePaths
    from nrp_core.recording.writing.signals import DeviceRecords as DeviceRecords
    from nrp_core.recording.writing.signals import LinkTransforms as LinkTransforms
    from nrp_core.recording.writing.signals import MovingModels as MovingModels
    from nrp_core.recording.writing.signals import PopulationSpikes as PopulationSpikes
    from nrp_core.recording.writing.signals import RecordEntry as RecordEntry
    from nrp_core.recording.writing.signals import Scenery as Scenery
    from nrp_core.recording.writing.signals import Signal as Signal
    from nrp_core.recording.writing.signals import TopicMessages as TopicMessages
else:
    __getattr__, __dir__, __all__ = lazily(__name__)
