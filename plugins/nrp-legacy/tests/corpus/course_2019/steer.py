from __future__ import division
from builtins import str, range
from past.utils import old_div
from future import standard_library
from future.utils import iteritems
standard_library.install_aliases()
import hbp_nrp_cle.tf_framework as nrp
from hbp_nrp_cle.robotsim.RobotInterface import Topic
import geometry_msgs.msg
from rospy_tutorials.msg import Floats
from places import grid, way

parts = {"first": old_div(7, 2), "second": old_div(7., 2)}


@nrp.MapRobotSubscriber("levels", Topic("/course/levels", Floats))
@nrp.MapRobotSubscriber("pose", Topic('/gazebo/model_states', gazebo_msgs.msg.ModelStates))
@nrp.MapRobotPublisher("said", Topic("said", std_msgs.msg.String))
@nrp.MapVariable("grid", initial_value=None)
@nrp.MapVariable("way", initial_value=None)
@nrp.MapCSVRecorder("recorder", filename="targets.csv", headers=["x", "y", "part", "other", "level"])
@nrp.Neuron2Robot(Topic('/p3dx/cmd_vel', geometry_msgs.msg.Twist))
def steer(t, pose, levels, said, grid, way, recorder):
    from places import grid as read_grid, way as read_way
    if grid.value is None:
        grid.value, way.value = read_grid(), read_way()
    x = way.value[1, 0]
    y = way.value[1, 1]
    target = [grid.value[x, y, 0.0], grid.value[x, y, 1.0]]
    recorder.record_entry(target[0], target[1], *([part for _, part in sorted(iteritems(parts))] + [levels.value and levels.value.data[1]]))
    here = pose.value.pose[pose.value.name.index('robot')].position
    said.send_message("one")
    said.send_message("two")
    return geometry_msgs.msg.Twist(linear=geometry_msgs.msg.Vector3(2.0 * (target[0] - here.x), 0.0, 0.0), angular=geometry_msgs.msg.Vector3(0.0, 0.0, 0.0))
