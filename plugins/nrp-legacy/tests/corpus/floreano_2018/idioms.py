# -*- coding: utf-8 -*-
"""One transfer function for each idiom."""
__author__ = 'Nobody'
from hbp_nrp_cle.tf_framework import *
from hbp_nrp_cle.tf_framework.tf_lib import *
import hbp_nrp_cle.tf_framework as nrp
from hbp_nrp_cle.robotsim.RobotInterface import Topic, PreprocessedTopic
import gazebo_msgs.msg, os, sys
from gazebo_ros_muscle_interface.msg import MuscleStates
from cle_ros_msgs.msg import SpikeEvent, SpikeRate
from std_msgs.msg import Float32, Float32MultiArray, Int32MultiArray, ColorRGBA, Bool, Empty
from geometry_msgs.msg import Twist, Vector3, Wrench, PoseStamped
from nav_msgs.msg import Odometry
import tf
import rospy
from arena_helper import SCALE, mean
sys.path.append(os.path.join(os.path.dirname(__file__), 'resources'))
import arena_helper
start_time = None


@nrp.MapSpikeSource("group", nrp.map_neurons(nrp.nrange(0, 4), lambda i: nrp.brain.sensors[i]), nrp.poisson, delay=0.1, weight=0.001)
@nrp.MapSpikeSource("chained", nrp.chain_neurons(nrp.brain.sensors[0], nrp.brain.actors[1]), nrp.fixed_frequency)
@nrp.MapSpikeSource("both", nrp.brain.sensors + nrp.brain.actors, nrp.poisson, target='excitatory', n=2)
@nrp.MapSpikeSource("picked", nrp.resolve(lambda brain: brain.odd), nrp.dc_source)
@nrp.MapSpikeSource("through_root", nrp.resolve(lambda: nrp.config.brain_root.odd[0:1]), nrp.dc_source)
@nrp.MapSpikeSource("noise", nrp.map_neurons(2, lambda i: nrp.brain.circuit[i]), nrp.nc_source, mean=0.0, stdev=0.001)
@nrp.Robot2Neuron()
def sources(t, group, chained, both, picked, through_root, noise):
    group.rate = np.ones(4) * 10.0
    group[0].rate = 5
    group[1:3].rate = [6.0, 7.0]
    assert len(group) == 4
    chained.rate = 20.0
    both.rate = np.linspace(0.0, 10.0, 8)
    picked.amplitude = 0.1
    through_root.amplitude = 0.01
    noise.mean = [0.1, 0.2]
    noise[0].std = 0.002


@nrp.MapSpikeSink("spikes", nrp.brain.record, nrp.spike_recorder)
@nrp.MapSpikeSink("groups", nrp.map_neurons(range(3), lambda i: nrp.brain.actors[i]), nrp.leaky_integrator_exp)
@nrp.MapSpikeSink("alpha", nrp.brain.actors, nrp.leaky_integrator_alpha, tau_m=10.0, tau_syn_E=2., v_rest=0.0, updates=[(1.0, 0.3)])
@nrp.MapRobotSubscriber("camera", Topic('/husky/husky/camera', sensor_msgs.msg.Image), initial_value=None)
@nrp.MapRobotSubscriber("joints", Topic('/husky/joint_states', sensor_msgs.msg.JointState))
@nrp.MapRobotSubscriber("odom", Topic('/husky/odom', Odometry))
@nrp.MapRobotSubscriber("speeds", Topic('/husky/husky/wheel_speeds', std_msgs.msg.Float64MultiArray))
@nrp.MapRobotSubscriber("muscles", Topic('/gazebo_muscle_interface/robot/muscle_states', MuscleStates))
@nrp.MapRobotSubscriber("red", PreprocessedTopic('/husky/husky/camera', sensor_msgs.msg.Image, lambda m: detect_red(m).left))
@nrp.MapVariable("seen", global_key="seen", initial_value=0, scope=nrp.GLOBAL)
@nrp.Neuron2Robot()
def sinks(t, spikes, groups, alpha, camera, joints, odom, speeds, muscles, red, seen):
    global start_time
    start_time = start_time or rospy.Time.now().to_sec()
    assert not spikes.spiked or spikes.times.any()
    assert len(groups.voltage) == 3
    alpha.voltage + groups[0].voltage
    if camera.value is not None and camera.changed:
        seen.value += 1
        assert camera.value.width == 32
    if t > 0:
        assert 'back_left_joint' in joints.value.name
        assert odom.value.pose.pose.position.z < 1.0
        assert red.value >= 0.0
    assert muscles.value is None
    tf.transformations.euler_from_quaternion([0.0, 0.0, 0.0, 1.0])


@nrp.MapVariable("pub", initial_value=rospy.Publisher('/husky/husky/cmd_vel', Twist, queue_size=10), scope=nrp.GLOBAL)
@nrp.Robot2Neuron(throttling_rate=10.0)
def rostopics(t, pub):
    msg = geometry_msgs.msg.Twist()
    msg.linear.x = 0.3
    pub.value.publish(msg)
    logger.info("published %s", msg)


@nrp.NeuronMonitor(nrp.brain.sensors, nrp.leaky_integrator_alpha)
def voltages(t):
    return True


@nrp.NeuronMonitor(nrp.brain.actors, nrp.population_rate)
def rates(t):
    return t > 0.1


@nrp.MapRobotSubscriber("camera", Topic('/husky/husky/camera', sensor_msgs.msg.Image))
@nrp.MapRobotPublisher("small", Topic("/small", sensor_msgs.msg.Image))
@nrp.Robot2Neuron(triggers=["camera"])
def triggered(t, camera, small):
    pass


@nrp.MapRobotPublisher("rat", Topic('/rat/p3dx/cmd_vel', Twist))
@nrp.MapRobotSubscriber("plain", Topic('/plain', std_msgs.msg.String))
@nrp.MapRobotSubscriber("rate", Topic('/monitor/population_rate', SpikeRate))
@nrp.MapRobotSubscriber("scan", Topic('/p3dx/laser/scan', sensor_msgs.msg.LaserScan))
@nrp.MapCSVRecorder("rows", filename="rat.csv", headers=["t", "text", "rate"])
@nrp.Neuron2Robot(Topic('/never/heard', Float32))
def other_robot(t, rat, plain, rate, scan, rows):
    rat.send_message(Twist(linear=Vector3(0.5, 0, 0), angular=Vector3()))
    rows.record_entry(t, plain.value.data if plain.value else "", rate.value.rate if rate.value else 0)
    return Float32(SCALE * mean([t]))
