"""
A kick at the handlebar
=======================

The FMUs of a motorcycle and of three devices, coupled: the steer angle after a kick of 0.5 rad/s at 30 m/s.
"""

import matplotlib.pyplot as plt

import motofmi as mf

_, axes = plt.subplots()
for label, device in {"no device": None, "rider": "rider:mean_2011", "damper": "damper:7.5"}.items():
    run = mf.cosimulate("sharp_1971", device, speed=30, duration=1.5, initial={"steer_rate": 0.5})
    axes.plot(run["time"], run["vehicle.steer_angle"], label=label)
axes.set(xlabel="time [s]", ylabel="steer angle [rad]")
axes.legend()
