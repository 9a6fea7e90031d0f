# Trials that call services of the experiment and offer one to it, in the style of the scripts of 2018.
import logging
import rospy
from std_msgs.msg import Float64
from std_srvs.srv import SetBool, SetBoolResponse, Trigger, TriggerResponse
from hbp_nrp_virtual_coach.virtual_coach import VirtualCoach


def reward(_request):
    return TriggerResponse(True, "reward %d" % trial)


rospy.Service("/reward", Trigger, reward)
learn = rospy.ServiceProxy("/learn", SetBool)
vc = VirtualCoach(environment="local", storage_username="nrpuser")

for trial in range(2):
    sim = vc.launch_experiment("served")
    sim._Simulation__logger.setLevel(logging.NOTSET)
    rospy.wait_for_service("/learn")
    print(learn(trial == 0).message)
    sim.start()
    while rospy.get_time() < 0.1:
        rospy.sleep(0.02)
    rospy.Publisher("/nobody/hears", Float64, queue_size=1).publish(0.5)
    sim.pause()
    print(learn(True).message)
    sim.stop()

try:
    learn(True)
except rospy.ServiceException as error:
    print(error)
