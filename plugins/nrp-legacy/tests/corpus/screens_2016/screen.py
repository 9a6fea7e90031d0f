# Imported Python Transfer Function
from std_msgs.msg import *
import hbp_nrp_cle.tf_framework as nrp
import rospy
from gazebo_msgs.srv import GetModelState, SetVisualProperties, ApplyJointEffort, SpawnEntity
import gazebo_msgs.srv

SDF = """<sdf version="1.5"><model name="ball"><pose>1 -2 0.5 0 0 0</pose><link name="link">
<collision name="c"><geometry><sphere><radius>0.1</radius></sphere></geometry></collision>
<visual name="v"><geometry><sphere><radius>0.1</radius></sphere></geometry></visual></link></model></sdf>"""

rospy.wait_for_service('/gazebo/spawn_sdf_entity')


@nrp.MapVariable("spawn", initial_value=rospy.ServiceProxy('/gazebo/spawn_sdf_entity', SpawnEntity), scope=nrp.GLOBAL)
@nrp.MapVariable("effort", initial_value=rospy.ServiceProxy('/gazebo/apply_joint_effort', gazebo_msgs.srv.ApplyJointEffort))
@nrp.MapVariable("done", initial_value=False)
@nrp.MapVariable("log", initial_value=None)
@nrp.MapCSVRecorder("recorder", filename="ball.csv", headers=["t", "z", "message"])
@nrp.Robot2Neuron()
def screen(t, spawn, effort, done, log, recorder):
    if not done.value:
        msg = gazebo_msgs.srv.SpawnEntityRequest()
        msg.entity_name = "ball"
        msg.entity_xml = SDF
        answer = spawn.value(msg)
        effort.value(joint_name="husky::back_left_joint", effort=0.1, start_time=rospy.Time(0, 0), duration=rospy.Duration(1.0))
        done.value = True
        recorder.record_entry(t, "", answer.success)
    state = rospy.ServiceProxy("/gazebo/get_model_state", GetModelState)('ball', 'world')
    recorder.record_entry(t, state.pose.position.z, state.status_message)
