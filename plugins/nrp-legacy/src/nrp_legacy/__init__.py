"""Run experiments of the Neurorobotics Platform (``.exc``, ``.bibi``, ``.exd``) unchanged."""
