"""The altimeter drives the cells for height and vertical speed; two groups set the thrust of the rotors.

A quadrotor tips over by itself, so a proportional-differential controller keeps the frame level, as in an
autopilot. The brain controls the height alone.
"""

from math import sqrt

import hbp_nrp_client.tf_framework as nrp
from ros_gz_interfaces.msg import Altimeter
from sensor_msgs.msg import Imu
from std_msgs.msg import Float64MultiArray

CELLS = 40
HEIGHT = 1.0  # m above the start
PER_METRE, PER_SPEED, MOST = 150.0, 160.0, 200.0  # Hz of a cell per m, per m/s, and at most
LIFT = 0.02  # m/s^2 for each Hz

MASS, GRAVITY = 0.54, 9.8
ARM, MOTOR, MOMENT = 0.106, 2.2e-6, 0.016  # m along x and y; N s^2/rad^2; m
SLOWEST, FASTEST = 100.0, 1200.0  # rad/s
INERTIA = (0.0035, 0.0035, 0.006)  # kg m^2
STIFF, DAMP = (60.0, 60.0, 4.0), (12.0, 12.0, 4.0)  # 1/s^2 and 1/s about x, y and z
ROTORS = ((1, 1, 1), (-1, -1, 1), (1, -1, -1), (-1, 1, -1))  # forward, left, and counter-clockwise


@nrp.MapRobotSubscriber("altimeter", nrp.Topic("/quadrotor/altimeter", Altimeter))
@nrp.MapSpikeSource("below", nrp.brain.below, nrp.poisson, weight=6.0)
@nrp.MapSpikeSource("above", nrp.brain.above, nrp.poisson, weight=6.0)
@nrp.MapSpikeSource("falling", nrp.brain.falling, nrp.poisson, weight=6.0)
@nrp.MapSpikeSource("rising", nrp.brain.rising, nrp.poisson, weight=6.0)
@nrp.Robot2Neuron(triggers=["altimeter"])
def feel(t, altimeter, below, above, falling, rising):
    """Drive one group by the height error, and one by the vertical speed."""
    error = PER_METRE * (HEIGHT - altimeter.value.vertical_position)
    climb = PER_SPEED * altimeter.value.vertical_velocity
    below.rate, above.rate = (min(max(each, 0.0), MOST) for each in (error, -error))
    rising.rate, falling.rate = (min(max(each, 0.0), MOST) for each in (climb, -climb))


@nrp.MapSpikeSink("lift", nrp.brain.lift, nrp.population_rate)
@nrp.MapSpikeSink("sink", nrp.brain.sink, nrp.population_rate)
@nrp.MapRobotSubscriber("imu", nrp.Topic("/quadrotor/imu", Imu))
@nrp.MapRobotPublisher("rotors", nrp.Topic("/quadrotor/command/motor_speed", Float64MultiArray))
@nrp.Neuron2Robot()
def fly(t, lift, sink, imu, rotors):
    """Set the rotor speeds that give the thrust of the two groups and keep the frame level."""
    if imu.value is None:
        return
    thrust = MASS * max(0.0, GRAVITY + LIFT * (lift.rate - sink.rate) / CELLS)
    turn, rate = imu.value.orientation, imu.value.angular_velocity
    angles = [2 * part * (1 if turn.w >= 0 else -1) for part in (turn.x, turn.y, turn.z)]  # small angles
    roll, pitch, yaw = (
        -moment * (stiff * angle + damp * speed)
        for moment, stiff, damp, angle, speed in zip(
            INERTIA, STIFF, DAMP, angles, (rate.x, rate.y, rate.z), strict=True
        )
    )
    speeds = []
    for forward, left, turning in ROTORS:
        share = (thrust + (left * roll - forward * pitch) / ARM - turning * yaw / MOMENT) / 4
        speeds.append(min(max(sqrt(max(share, 0.0) / MOTOR), SLOWEST), FASTEST))
    rotors.send_message(Float64MultiArray(data=speeds))
