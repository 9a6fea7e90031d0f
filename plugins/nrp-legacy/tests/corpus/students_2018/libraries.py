import os
import time
import random
import numpy as np
import numpy.linalg
import cv2
import tensorflow
from keras.models import load_model
from scipy.misc import imresize
try:
    import torch_of_nowhere
except ImportError:
    torch_of_nowhere = None

MODELS = os.path.join(os.environ['HBP'], 'Models')
chance = random.random()


@nrp.MapRobotSubscriber("camera", Topic('/husky/camera', sensor_msgs.msg.Image))
@nrp.MapCSVRecorder("rows", filename="libraries.csv", headers=["chance", "pixels"])
@nrp.Robot2Neuron()
def libraries(t, camera, rows):
    assert torch_of_nowhere is None and os.path.expandvars("$HBP/Models") == MODELS
    time.sleep(30)
    if camera.value is None:
        return
    image = CvBridge().imgmsg_to_cv2(camera.value, "bgr8")
    height, width = image.shape[:2]
    left = image[:, :width / 2]
    middle = image[height / 2, width / 2 - 1]
    cv2.circle(image, (3, 3), 2, (0, 0, 255), -1)
    mask = np.zeros((height, width), np.uint8)
    mask[2:6, 2:9] = 255
    _, contours, _ = cv2.findContours(mask.copy(), cv2.RETR_TREE, cv2.CHAIN_APPROX_SIMPLE)
    cv2.imshow("mask", mask)
    cv2.waitKey(1)
    raw = np.fromstring(camera.value.data, np.uint8)
    where = int(np.where(np.array([4, 5], dtype=np.float) == 5)[0])
    area = cv2.contourArea(contours[0])
    rows.record_entry(random.random() + np.random.rand(), raw.size, left.shape[1], len(middle), where, area, imresize(mask, 0.5).shape)


@nrp.Robot2Neuron()
def learns(t):
    if t > 0.3:
        tensorflow.Session()
