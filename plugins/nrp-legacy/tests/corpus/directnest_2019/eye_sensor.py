@nrp.MapRobotSubscriber("camera", Topic('/husky/husky/camera', sensor_msgs.msg.Image))
@nrp.MapSpikeSource("red_left_eye", nrp.brain.sensors[0:3:2], nrp.dc_source)
@nrp.MapSpikeSource("red_right_eye", nrp.brain.sensors[1:4:2], nrp.nc_source, mean=0.0, std=1.0)
@nrp.MapSpikeSource("green_blue_eye", nrp.brain.sensors[4], nrp.ac_source, frequency=5.0)
@nrp.Robot2Neuron()
def eye_sensor_transmit(t, camera, red_left_eye, red_right_eye, green_blue_eye):
    image_results = hbp_nrp_cle.tf_framework.tf_lib.detect_red(image=camera.value)
    red_left_eye.amplitude = 200.0 * image_results.left + 150.0
    red_right_eye.mean = 200.0 * image_results.right + 150.0
    green_blue_eye.amplitude = 7.5 * image_results.go_on
