"""
What if the steering damper is stronger?
========================================

The damping ratios of weave and wobble over speed for three steering dampers.
"""

import matplotlib.pyplot as plt
import numpy as np

import motofmi as mf

speed = np.arange(5.0, 60.5, 2.5)
dampers = {f"{value:g} N.m.s/rad": mf.damper(value) for value in (0.0, 7.5, 15.0)}
found = mf.compare_modes("sharp_1971", dampers, speed=speed)

_, pair = plt.subplots(1, 2, figsize=(9, 4), layout="constrained")
for axes, mode in zip(pair, ("weave", "wobble"), strict=True):
    for name in dampers:
        axes.plot(speed, found[name][mode].damping_ratio, label=name)
    axes.axhline(0.0, color="0.6", linewidth=0.8)
    axes.set(xlabel="speed [m/s]", ylabel="damping ratio [1]", title=mode)
pair[0].legend()
