@nrp.MapSpikeSink("left", nrp.brain.actors[0], nrp.population_rate)
@nrp.MapSpikeSink("right", nrp.brain.actors[1], nrp.population_rate, tau_fall=50., tau_rise=5.)
@nrp.MapVariable("last", global_key="last_speed", initial_value=0.0, scope=nrp.GLOBAL)
@nrp.Neuron2Robot(Topic('/robot/p3dx/cmd_vel', geometry_msgs.msg.Twist), throttling_rate=25)
def drive(t, left, right, last):
    last.value = 0.01 * (left.rate + right.rate) / N_SECTORS
    return geometry_msgs.msg.Twist(linear=geometry_msgs.msg.Vector3(x=last.value, y=0.0, z=0.0),
                                   angular=geometry_msgs.msg.Vector3(x=0.0, y=0.0, z=0.01 * (right.rate - left.rate)))
