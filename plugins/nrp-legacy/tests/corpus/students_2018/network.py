import socket
@nrp.MapRobotSubscriber("said", Topic('/said', std_msgs.msg.String))
@nrp.MapCSVRecorder("rows", filename="said.csv", headers=["said"])
@nrp.Robot2Neuron()
def said(t, said, rows):
    if said.changed:
        rows.record_entry(said.value.data)
