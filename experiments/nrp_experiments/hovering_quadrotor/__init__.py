"""A quadrotor that holds its height."""
