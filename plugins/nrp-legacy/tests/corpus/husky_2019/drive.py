import rospy
from gazebo_msgs.srv import GetModelState
from std_msgs.msg import Float64
from tf.transformations import euler_from_quaternion

state = rospy.ServiceProxy("/gazebo/get_model_state", GetModelState)
publisher = rospy.Publisher("/yaw", Float64, queue_size=1)
heard = []
rospy.Subscriber("/yaw", Float64, lambda message: heard.append(message.data))
rospy.wait_for_service("/gazebo/get_model_state")


@nrp.MapRobotSubscriber("camera", Topic("/husky/husky/camera", sensor_msgs.msg.Image))
@nrp.MapSpikeSink("rate", nrp.brain.record[1], nrp.population_rate)
@nrp.MapSpikeSink("exp", nrp.brain.record[slice(0, 2, 1)], nrp.leaky_integrator_exp, weight=1.0)
@nrp.Neuron2Robot(Topic("/husky/husky/cmd_vel", geometry_msgs.msg.Twist))
def drive(t, camera, rate, exp):
    image = CvBridge().imgmsg_to_cv2(camera.value, "rgb8")
    assert image.shape == (24, 32, 3), image.shape
    pose = state("second", "world").pose
    q = pose.orientation
    publisher.publish(euler_from_quaternion([q.x, q.y, q.z, q.w])[2])
    assert rospy.Time.now().to_sec() == rospy.get_time()
    if t > 0.1:
        assert abs(abs(heard[-1]) - np.pi) < 0.05, heard
    return geometry_msgs.msg.Twist(
        linear=geometry_msgs.msg.Vector3(0.5, 0, 0), angular=geometry_msgs.msg.Vector3(0, 0, 0)
    )
