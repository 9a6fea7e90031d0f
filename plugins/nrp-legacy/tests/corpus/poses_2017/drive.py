import rospy
from std_srvs.srv import SetBool, SetBoolResponse

gate = {'open': False}


def open_gate(request):
    gate['open'] = request.data
    return SetBoolResponse(True, 'the gate is %s' % ('open' if request.data else 'closed'))


server = rospy.Service('gate', SetBool, open_gate)


@nrp.MapCSVRecorder("recorder", filename="gate.csv", headers=["time", "open"])
@nrp.Neuron2Robot(Topic('/husky/cmd_vel', geometry_msgs.msg.Twist))
def drive(t, recorder):
    recorder.record_entry(t, gate['open'])
    return geometry_msgs.msg.Twist(linear=geometry_msgs.msg.Vector3(0.5, 0, 0), angular=geometry_msgs.msg.Vector3(0, 0, 0))
