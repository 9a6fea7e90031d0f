# Generations of a movement, in the style of genetic searches: edit, start, wait, pause, read, reset.
import time

from pynrp.virtual_coach import VirtualCoach

last_status = [None]


def on_status(status):
    last_status[0] = status


def wait_condition(timeout, condition):
    start = time.time()
    while time.time() < start + timeout:
        time.sleep(0.05)
        if last_status[0] is not None and condition(last_status[0]):
            return
    raise Exception("Condition check failed")


speed_tf = """@nrp.MapCSVRecorder("recorder", filename="speed.csv", headers=["time", "speed"])
@nrp.MapVariable("last", global_key="last_speed", initial_value=0.0, scope=nrp.GLOBAL)
@nrp.Robot2Neuron()
def record_speed(t, recorder, last):
    recorder.record_entry(t, last.value)
"""
drive_tf = """@nrp.MapVariable("last", global_key="last_speed", initial_value=0.0, scope=nrp.GLOBAL)
@nrp.Neuron2Robot(Topic('/robot/p3dx/cmd_vel', geometry_msgs.msg.Twist))
def drive(t, last):
    last.value = {} * t
    return geometry_msgs.msg.Twist(linear=geometry_msgs.msg.Vector3(x=last.value, y=0.0, z=0.0))
"""

vc = VirtualCoach(environment="local")
sim = vc.launch_experiment("p3dx_2018")
sim.register_status_callback(on_status)
wait_condition(10, lambda x: x["state"] == "paused")
sim.add_transfer_function(speed_tf)
for gain in (0.25, 0.5):
    sim.edit_transfer_function("drive", drive_tf.format(gain))
    sim.start()
    wait_condition(60, lambda x: x["simulationTime"] > 1.0)
    sim.pause()
    assert sim.get_state() == "paused"
    rows = sim.get_csv_data("speed.csv")
    print(gain, rows[-1][0], rows[-1][1])
    sim.reset("full")
    wait_condition(10, lambda x: x["simulationTime"] == 0.0 and x["state"] == "paused")
sim.stop()
