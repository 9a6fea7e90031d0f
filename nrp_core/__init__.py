"""A closed loop between a spiking brain and a simulated body, with any simulator on either side."""
