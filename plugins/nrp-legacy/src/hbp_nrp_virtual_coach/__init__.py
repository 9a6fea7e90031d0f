"""The Virtual Coach of the Neurorobotics Platform: scripts launch and steer experiments, in this process.

::

    from hbp_nrp_virtual_coach.virtual_coach import VirtualCoach

    coach = VirtualCoach(environment="experiments")
    simulation = coach.launch_experiment("my_experiment")
    simulation.start()
"""
