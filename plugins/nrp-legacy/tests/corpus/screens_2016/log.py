from hbp_nrp_excontrol.logs import clientLogger
import logging
logger = logging.getLogger(__name__)
@nrp.MapRobotSubscriber("position", Topic('/gazebo/model_states', gazebo_msgs.msg.ModelStates))
@nrp.MapRobotSubscriber("links", Topic('/gazebo/link_states', gazebo_msgs.msg.LinkStates))
@nrp.MapVariable("ideal_wheel_speed_norm", global_key="ideal_wheel_speed_norm", initial_value=0.0)
@nrp.MapCSVRecorder("recorder", filename="robot_position.csv", headers=["Time", "px", "py", "pz"])
@nrp.Robot2Neuron()
def log(t, position, links, ideal_wheel_speed_norm, recorder):
    if t % 1 < 0.02:
        clientLogger.info('Time: ', t)
        clientLogger.advertise("It is %s" % t)
    if not isinstance(position.value, type(None)) and 'husky' in position.value.name:
        p = position.value.pose[position.value.name.index('husky')].position
        recorder.record_entry(t, p.x, p.y, p.z)
