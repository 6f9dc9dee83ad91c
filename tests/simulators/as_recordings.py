"""Arrays of a simulated rig as recordings, as if read from files."""

from motofmi.recordings.recording import Recording

UNITS = {"steer_angle_command": "rad", "steer_angle": "rad", "steer_torque": "N.m"}


def as_recording(name, arrays):
    time, *columns = arrays
    return Recording(name, time, dict(zip(UNITS, columns, strict=False)), UNITS)
