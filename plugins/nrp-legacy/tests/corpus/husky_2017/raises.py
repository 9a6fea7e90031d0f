@nrp.MapRobotSubscriber("nobody", Topic("/nobody/serves/this", std_msgs.msg.String))
@nrp.Robot2Neuron()
def raises(t, nobody):
    if t >= 0.1:
        nobody.value.data
