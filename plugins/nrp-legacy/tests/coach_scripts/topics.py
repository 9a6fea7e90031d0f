# Trials that speak to the simulation by rospy, in the style of the scripts of 2018, which were Python 2.
import csv
import os
import sys
import time

import rospy
import std_msgs.msg
from gazebo_msgs.msg import ModelState, ModelStates
from gazebo_msgs.srv import GetModelState
from tf.transformations import quaternion_from_euler
from hbp_nrp_virtual_coach.virtual_coach import VirtualCoach

heard = []
places = []


def hear(message):
    heard.append(message.data)


def see(message):
    places.append(message.pose[message.name.index('robot')].position.y)


rospy.Subscriber('/said', std_msgs.msg.String, hear)
rospy.Subscriber('/gazebo/model_states', ModelStates, see)
set_model_state = rospy.Publisher('/gazebo/set_model_state', ModelState)
get_model_state = rospy.ServiceProxy('/gazebo/get_model_state', GetModelState)
vc = VirtualCoach(environment='local', storage_username='nrpuser')

for trial in range(2):
    sim = vc.launch_experiment('course_2019')
    del heard[:], places[:]
    state = ModelState()
    state.model_name = 'robot'
    state.reference_frame = 'world'
    state.scale.x = state.scale.y = state.scale.z = 1.0
    state.pose.position.y = 0.25 * (trial + 1)
    state.pose.position.z = 0.02
    x, y, z, w = quaternion_from_euler(0, 0, 0)
    state.pose.orientation.w = w
    set_model_state.publish(state)
    print "put at %.2f" % get_model_state('robot', 'world').pose.position.y
    rospy.set_param('trial', trial)
    sim.start()
    while rospy.get_time() < 0.5:
        time.sleep(0.001)
    before = rospy.get_time()
    rospy.sleep(0.4)
    last = rospy.wait_for_message('/said', std_msgs.msg.String, timeout=30)
    sim.pause()
    print rospy.get_time() - before >= 0.4, rospy.get_param('answer') == trial + 7 / 2
    print heard[:3], last.data in ('one', 'two'), "seen at %.2f" % places[0]
    sim.stop()

with open(os.path.join(sys.argv[1], 'rows.csv'), 'wb') as f:
    csv.writer(f, lineterminator='\n').writerows([['trials', 2]])
