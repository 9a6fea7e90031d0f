"""A file of transfer functions as an editor sees it; mypy checks this file, nothing runs it."""

from __future__ import annotations

from typing import Any, assert_type

import geometry_msgs.msg
import hbp_nrp_client.tf_framework as nrp
import numpy as np
import numpy.typing as npt
from actionlib_msgs.msg import GoalStatus
from cv_bridge import CvBridge
from gazebo_msgs.srv import SetModelState, SetModelStateRequest
from geometry_msgs.msg import AccelStamped, Header, Twist, Vector3  # type: ignore[attr-defined]
from sensor_msgs.msg import Image, LaserScan, PointField
from std_msgs.msg import Float64


@nrp.MapRobotSubscriber("camera", nrp.Topic("/husky/camera", Image))
@nrp.MapSpikeSource("left", nrp.brain.eyes[0], nrp.poisson, weight=20.0)
@nrp.Robot2Neuron()
def see(t: float, camera: Any, left: Any) -> None:
    image: Image = camera.value
    assert_type(image.width, int)
    left.rate = float(np.mean(CvBridge().imgmsg_to_cv2(image, "rgb8")))


@nrp.Neuron2Robot(nrp.Topic("/husky/cmd_vel", geometry_msgs.msg.Twist))
def drive(t: float) -> Twist:
    assert_type(Twist().linear.x, float)
    Twist(linear=0.5)  # type: ignore[arg-type]
    return Twist(linear=Vector3(1, 0, 0))


def written_out_and_made() -> None:
    assert_type(Float64(1.5).data, float)
    assert_type(LaserScan().range_max, float)
    assert_type(AccelStamped().accel.linear, Vector3)
    assert_type(AccelStamped().header.frame_id, str)
    assert_type(PointField().offset, int)
    assert_type(GoalStatus.SUCCEEDED, int)
    assert_type(SetModelState.Request(), SetModelStateRequest)
    covariance: npt.NDArray[Any] = geometry_msgs.msg.AccelWithCovariance().covariance
    assert_type(covariance.size, int)
    assert Header is not None
