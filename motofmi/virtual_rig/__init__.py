"""A simulated test rig, recorded as the real rig records."""
