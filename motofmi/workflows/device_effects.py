"""Every shipped device as an effect at a vehicle's handlebar, with the spread of its published values as prior.

The prior of a further rider is the predictive distribution of a normal sample of n riders in the logarithms of p
parameters, with the mean and the covariance S of the population (`motofmi.identification.population`):

    covariance = S (n + 1) (n - 1) / (n (n - p - 2))

This is the covariance of Student's t with n - p degrees of freedom: mean and covariance of ten riders are uncertain
themselves. A device with fewer published values is known within a factor of `WITHIN` of their geometric mean.

Source: Gelman et al., Bayesian Data Analysis (3rd ed., 2013), Sect. 3.6.
"""

from collections import defaultdict
from collections.abc import Sequence

import numpy as np

from fmus.composition.value_files import Library
from fmus.declaration.component import Component
from fmus.effects.prior import LogNormalPrior
from fmus.interfaces.device_effect import DeviceEffect, device_effect
from fmus.interfaces.handlebar import HandlebarDevice
from fmus.interfaces.posture_inertia import POSTURE
from motofmi.identification.population import population

WITHIN = 2.0  # factor of uncertainty of a parameter with few published values
PERSON, BAR = "height", "handlebar_inertia"  # keys of [about]: of one rider, and of the bar that the rig measures with
ADDED = "added_steer_inertia"


def device_effects(*libraries: Library) -> list[type[DeviceEffect]]:
    """One effect for each class of devices at the handlebar that a value file of the libraries names.

    A device whose inertia changes with posture is left out: linearised it is the passive rider.
    """
    files: dict[str, list[tuple[Library, str]]] = defaultdict(list)
    for library in libraries:
        for name in library.names():
            title = str(library.contents(name)["component"])
            kind = library.components.get(title)
            if kind is not None and issubclass(kind, HandlebarDevice) and not set(POSTURE) <= kind.declared.keys():
                files[title].append((library, name))
    return [_effect(each) for each in files.values()]


def _effect(files: Sequence[tuple[Library, str]]) -> type[DeviceEffect]:
    """The effect of the devices of one class: the prior is that of the largest sample of persons, or of all files."""
    sources: dict[str, list[tuple[Library, str]]] = defaultdict(list)
    for library, name in files:
        contents = library.contents(name)
        if PERSON in contents.get("about", {}):
            sources[contents.get("source", "")].append((library, name))
    persons = max(sources.values(), key=len, default=[])
    sample = [library.load(name) for library, name in persons or files]
    bars = [library.contents(name)["about"].get(BAR, {"value": 0.0})["value"] for library, name in persons]
    device = sample[0]
    assert isinstance(device, HandlebarDevice)
    return device_effect(device, _prior(sample, {ADDED: float(bars[0])} if bars and ADDED in device.values else {}))


def _prior(sample: Sequence[Component], offsets: dict[str, float]) -> LogNormalPrior:
    """The prior of a further device beside a sample of its class."""
    names = tuple(n for n in sample[0].values if n in offsets or any(c.values[n] > 0 for c in sample))
    offset = np.array([offsets.get(n, 0.0) for n in names])
    n, p = len(sample), len(names)
    values = np.array([[c.values[name] for name in names] for c in sample])
    if n > p + 2:
        mean, covariance = population(sample, names, offsets).logarithmic
        return LogNormalPrior(names, offset, mean, covariance * (n + 1) * (n - 1) / (n * (n - p - 2)), values)
    return LogNormalPrior(names, offset, np.log(values + offset).mean(axis=0), np.eye(p) * np.log(WITHIN) ** 2, values)
