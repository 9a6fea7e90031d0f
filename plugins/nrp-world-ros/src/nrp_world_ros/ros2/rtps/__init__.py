"""Services of ROS 2: the part of RTPS, the protocol below DDS, that ties an answer to its call.

Fast DDS, the default of ROS 2, does so in fields of a packet that the Python interface of Cyclone DDS does
not reach; Cyclone DDS does so in the data. Numbers and names are those of the standard DDSI-RTPS 2.3.
"""
