# An installed experiment, with a function more; the file of the run is read when it is over.
import time

from hbp_nrp_virtual_coach import virtual_coach

vc = virtual_coach.VirtualCoach("local")
sim = vc.launch_experiment("braitenberg_husky/no_red")
with open("spikes.py") as f:
    sim.add_transfer_function(f.read())
sim.start()
while sim.get_state() != "stopped":
    time.sleep(0.1)
print(vc.get_last_run_file("braitenberg_husky/no_red", "csv", "all_spikes.csv").decode(), end="")
