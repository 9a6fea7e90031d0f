"""The methods of the Virtual Coach have the arguments of ``pynrp`` 3.2.1, as in its wheel on PyPI."""

from __future__ import annotations

import ast
import inspect

import pytest
from hbp_nrp_virtual_coach.simulation import Simulation
from hbp_nrp_virtual_coach.virtual_coach import VirtualCoach

COACH = """
__init__(environment='http://localhost:9000', oidc_username=None, oidc_password=None, \
storage_username=None, storage_password=None)
launch_experiment(experiment_id, server=None, reservation=None, cloned=True, \
brain_processes=1, profiler='disabled', recordingPath=None)
print_templates(dev=False)
print_running_experiments(cloned=False)
print_cloned_experiments()
print_available_servers()
clone_experiment_to_storage(exp_id)
delete_cloned_experiment(exp_id)
clone_cloned_experiment(experiment_id)
print_experiment_runs_files(exp_id, file_type)
print_experiment_run_files(exp_id, file_type, run_id)
print_last_run_files(exp_id, file_type)
get_experiment_run_file(exp_id, file_type, run_id, file_name)
get_last_run_file(exp_id, file_type, file_name)
set_experiment_file(exp_id, file_name, file_content)
import_experiment(path)
print_available_models(model_type, user='all')
import_model(path, model_type)
delete_model(model_type, name)
"""
SIMULATION = """
start()
pause()
stop()
register_status_callback(callback)
get_state()
print_transfer_functions()
print_state_machines()
get_transfer_function(transfer_function_name)
edit_transfer_function(transfer_function_name, transfer_function)
add_transfer_function(transfer_function)
delete_transfer_function(transfer_function_name)
save_transfer_functions()
save_state_machines()
save_brain()
save_world()
get_state_machine(state_machine_name)
edit_state_machine(state_machine_name, state_machine)
add_state_machine(state_machine_name, state_machine)
delete_state_machine(state_machine_name)
get_brain()
edit_brain(brain_script)
get_populations()
edit_populations(populations)
reset(reset_type)
get_csv_last_run_file(file_name)
start_recording()
stop_recording(save, description=None)
pause_recording()
unpause_recording()
"""


@pytest.mark.parametrize(
    ("kind", "line"),
    [
        (kind, line)
        for kind, text in ((VirtualCoach, COACH), (Simulation, SIMULATION))
        for line in text.strip().splitlines()
    ],
)
def test_a_method_has_the_arguments_of_pynrp(kind: type, line: str) -> None:
    name = line.partition("(")[0]
    (function,) = ast.parse(f"def {line}: pass").body
    assert isinstance(function, ast.FunctionDef)
    theirs = [one.arg for one in function.args.args]
    defaults = [ast.literal_eval(one) for one in function.args.defaults]
    _, *ours = inspect.signature(getattr(kind, name)).parameters.values()
    positional = [one for one in ours if one.kind is one.POSITIONAL_OR_KEYWORD]
    assert [one.name for one in positional] == theirs
    assert [one.default for one in positional if one.default is not one.empty] == defaults
