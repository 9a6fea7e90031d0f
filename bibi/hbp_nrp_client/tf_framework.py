"""``import hbp_nrp_client.tf_framework as nrp``: the transfer function language.

Importing it also lets plain scripts ``import geometry_msgs.msg`` and the other message packages
where ROS is not installed.
"""

from __future__ import annotations

from nrp_core.dsl import *  # noqa: F403
from nrp_core.dsl import __all__ as __all__
from nrp_core.dsl import provide_messages

provide_messages()
