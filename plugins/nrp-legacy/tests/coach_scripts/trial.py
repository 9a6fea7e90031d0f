# One trial, in the style of the scripts of 2018: a status callback ends it at a time.
import csv
import os
import sys

try:
    from hbp_nrp_virtual_coach.virtual_coach import VirtualCoach

    vc = VirtualCoach(environment="local", storage_username="nrpuser")
except ImportError as e:
    print(e)
    raise e

csv_name = "spikes.csv"
datadir = sys.argv[1]


def save_csv(sim, datadir):
    with open(os.path.join(datadir, csv_name), "w") as f:
        cf = csv.writer(f, lineterminator="\n")
        csv_data = sim.get_csv_data(csv_name)
        cf.writerows(csv_data)


def make_on_status(sim, datadir):
    def on_status(msg):
        print("Current simulation time: {}".format(msg["simulationTime"]))
        if msg["simulationTime"] == 1.0 and sim.get_state() == "started":
            sim.pause()
            save_csv(sim, datadir)
            sim.stop()
            print(f"Trial terminated - saved CSV in {datadir}")

    return on_status


vc.print_cloned_experiments()
servers = vc.print_available_servers()
sim = vc.launch_experiment("p3dx_2018", server=servers[0])
assert sim.get_state() == "paused"
sim.register_status_callback(make_on_status(sim, datadir))
sim.start()
while sim.get_state() != "stopped":
    pass
