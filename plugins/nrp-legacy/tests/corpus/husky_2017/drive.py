@nrp.MapVariable("seen", global_key="seen", scope=nrp.GLOBAL)
@nrp.MapSpikeSink("wheels", nrp.map_neurons(range(0, 2), lambda i: nrp.brain.record[i]), nrp.leaky_integrator_alpha)
@nrp.Neuron2Robot(Topic('/husky/cmd_vel', geometry_msgs.msg.Twist))
def drive(t, seen, wheels):
	print "turning", seen.value
	left, right = wheels.voltage
	angular = 3 / 2
        return geometry_msgs.msg.Twist(linear=geometry_msgs.msg.Vector3(x=0, y=0, z=0),
                                       angular=geometry_msgs.msg.Vector3(0, 0, 0.1 * angular))
