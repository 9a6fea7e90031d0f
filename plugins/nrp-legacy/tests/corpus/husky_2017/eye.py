import hbp_nrp_cle.tf_framework as nrp
import sensor_msgs.msg
from hbp_nrp_cle.robotsim.RobotInterface import Topic


@nrp.MapRobotSubscriber("camera", Topic("/husky/camera", sensor_msgs.msg.Image))
@nrp.MapSpikeSource("left_eye", nrp.brain.left, nrp.poisson, weight=0.00015)
@nrp.MapSpikeSource("right_eye", nrp.brain.right[0], nrp.poisson)
@nrp.MapVariable("seen", global_key="seen", initial_value=0.0, scope=nrp.GLOBAL)
@nrp.Robot2Neuron()
def eye(t, camera, left_eye, right_eye, seen):
    image_results = hbp_nrp_cle.tf_framework.tf_lib.detect_red(image=camera.value)
    seen.value = max(seen.value, image_results.left + image_results.right)
    left_eye.rate = 2000.0 * image_results.left
    right_eye.rate = 2000.0 * image_results.right
    clientLogger.info("red:", seen.value)
