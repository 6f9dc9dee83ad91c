"""Kinematics and dynamics of the six-body rider."""
