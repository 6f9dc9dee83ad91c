"""A simulated test rig with the sensors of the real one."""
