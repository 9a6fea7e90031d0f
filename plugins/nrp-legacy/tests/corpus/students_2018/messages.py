import rospy
import roslib
roslib.load_manifest('students')
from geometry_msgs.msg import *
from tigrillo_msgs.msg import Motors
from students_msgs.srv import Drive, DriveRequest
from gazebo_msgs.srv import ApplyJointEffort
from gazebo_msgs.msg import ModelState
from tf.transformations import quaternion_from_euler, euler_from_quaternion, quaternion_about_axis

PoseStamped().header.seq


class Listening(object):
    def __init__(self):
        self.ticks, self.names = [], []
        self.subscriber = rospy.Subscriber('/husky/joint_states', sensor_msgs.msg.JointState, self.heard)
        self.timer = rospy.Timer(rospy.Duration(0.1), self.tick)

    def heard(self, message):
        self.names = message.name

    def tick(self, event):
        self.ticks.append(event.current_real.to_sec())


@nrp.MapVariable("node", initial_value=Listening(), scope=nrp.GLOBAL)
@nrp.MapRobotPublisher("motors", Topic('/motors', Motors))
@nrp.MapRobotSubscriber("motors_again", Topic('/motors', Motors))
@nrp.MapCSVRecorder("rows", filename="messages.csv", headers=["ticks", "names", "speed"])
@nrp.Neuron2Robot()
def messages(t, node, motors, motors_again, rows):
    message = Motors(front_left=t)
    message.header.stamp = rospy.Time.now()
    motors.send_message(message)
    state = ModelState(model_name='husky')
    state.scale.x = 2.0
    turned = euler_from_quaternion(quaternion_from_euler(0.1, 0.2, 0.3, 'rzyx'), 'rzyx')
    assert abs(turned[2] - 0.3) < 1e-9 and abs(quaternion_about_axis(0.0, (0, 0, 1))[3] - 1.0) < 1e-9
    rospy.ServiceProxy('/gazebo/apply_joint_effort', ApplyJointEffort)('back_left_joint', 0.1, None, rospy.Duration(0.01))
    try:
        rospy.ServiceProxy('/drive', Drive)(DriveRequest(speed=1))
    except rospy.ServiceException as error:
        rospy.logwarn_once(str(error))
    rows.record_entry(len(node.value.ticks), len(node.value.names), motors_again.value.front_left if motors_again.value else -1)
