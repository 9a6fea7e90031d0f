import smach
from hbp_nrp_excontrol.nrp_states import RobotTwistMonitorState, WaitToClockState
sm = smach.StateMachine(outcomes=["FINISHED", "PREEMPTED"])
with sm:
    smach.StateMachine.add("moves", RobotTwistMonitorState("husky", lambda ud, twist: abs(twist.linear.x) < 1e9),
                           transitions={'valid': "moves", 'invalid': "FINISHED", "preempted": "PREEMPTED"})
