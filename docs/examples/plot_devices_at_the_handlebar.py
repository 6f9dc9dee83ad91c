"""
Rider and damper at the handlebar
=================================

The torque of a rider and of two dampers per steer angle. The damper's rises with the frequency; the rider's has the
resonances of torso and arms.
"""

import matplotlib.pyplot as plt
import numpy as np

import motofmi as mf

frequency = np.geomspace(0.3, 12.0, 200)
_, (magnitude, phase) = plt.subplots(2, 1, sharex=True)
for name in ("rider:mean_2011", "damper:7.5", "damper:inerter"):
    torque = mf.transfer_functions(name, frequency)["handlebar_torque"]
    magnitude.loglog(frequency, abs(torque), label=name)
    phase.semilogx(frequency, np.degrees(np.angle(torque)))
magnitude.set(ylabel="torque per angle [N.m/rad]")
phase.set(xlabel="frequency [Hz]", ylabel="phase [deg]")
magnitude.legend()
