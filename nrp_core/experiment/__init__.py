"""Experiments: read, check and run them, and evaluate the results.

``reading`` reads files, ``making`` makes the parts, ``running`` runs them; ``model`` defines the contents of
a file. The names here are those that authors of readers and platforms need; each is imported when it is first
used.
"""

from nrp_core._support.lazy import lazily

TYPE_CHECKING = False  # type checkers know this name; importing typing would take 5 ms
if TYPE_CHECKING:
    from nrp_core.experiment.backends import code_of as code_of
    from nrp_core.experiment.events.criteria import Verdict as Verdict
    from nrp_core.experiment.making.maker import LISTERS as LISTERS
    from nrp_core.experiment.making.maker import Maker as Maker
    from nrp_core.experiment.making.maker import build_here as build_here
    from nrp_core.experiment.making.maker import load_function_file as load_function_file
    from nrp_core.experiment.making.maker import network_from as network_from
    from nrp_core.experiment.making.maker import scene_of as scene_of
    from nrp_core.experiment.making.maker import with_parameters as with_parameters
    from nrp_core.experiment.making.plan import Plan as Plan
    from nrp_core.experiment.making.prepare import load_functions as load_functions
    from nrp_core.experiment.making.prepare import make_parts as make_parts
    from nrp_core.experiment.making.prepare import prepare as prepare
    from nrp_core.experiment.model.collector import Collector as Collector
    from nrp_core.experiment.model.collector import Omission as Omission
    from nrp_core.experiment.model.collector import describe_fault as describe_fault
    from nrp_core.experiment.model.event_schema import Criterion as Criterion
    from nrp_core.experiment.model.event_schema import Event as Event
    from nrp_core.experiment.model.experiment import BackendSection as BackendSection
    from nrp_core.experiment.model.experiment import Build as Build
    from nrp_core.experiment.model.experiment import Experiment as Experiment
    from nrp_core.experiment.model.section import Key as Key
    from nrp_core.experiment.model.section import Name as Name
    from nrp_core.experiment.model.section import Place as Place
    from nrp_core.experiment.model.section import Range as Range
    from nrp_core.experiment.model.section import Section as Section
    from nrp_core.experiment.model.section import Tree as Tree
    from nrp_core.experiment.model.section import keyed_range as keyed_range
    from nrp_core.experiment.model.section import tree_of as tree_of
    from nrp_core.experiment.model.variant_schema import InterventionSection as InterventionSection
    from nrp_core.experiment.reading.find import READERS as READERS
    from nrp_core.experiment.reading.find import SHIPPED as SHIPPED
    from nrp_core.experiment.reading.find import experiments_in as experiments_in
    from nrp_core.experiment.reading.find import find_file as find_file
    from nrp_core.experiment.reading.find import load_experiment as load_experiment
    from nrp_core.experiment.reading.find import shipped as shipped
    from nrp_core.experiment.reading.reader import Platform as Platform
    from nrp_core.experiment.reading.reader import experiment_of as experiment_of
    from nrp_core.experiment.reading.reader import form_of as form_of
    from nrp_core.experiment.reading.reader import overridden as overridden
    from nrp_core.experiment.reading.reader import read_form as read_form
    from nrp_core.experiment.reading.reader import read_form_tree as read_form_tree
    from nrp_core.experiment.reading.reader import read_yaml as read_yaml
    from nrp_core.experiment.reading.yaml_tree import parse_tree as parse_tree
    from nrp_core.experiment.running.control_commands import commands_of as commands_of
    from nrp_core.experiment.running.observers import Participant as Participant
    from nrp_core.experiment.running.observers import RunObserver as RunObserver
    from nrp_core.experiment.running.result import Result as Result
    from nrp_core.experiment.running.result import recorded_judgement as recorded_judgement
    from nrp_core.experiment.running.run import Run as Run
else:
    __getattr__, __dir__, __all__ = lazily(__name__)
