"""The brain side: networks, devices, and the interface of a spiking simulator."""
