"""Experiments of the Neurorobotics Platform (``.exc``, ``.bibi``, ``.exd``) as their users have them."""
