"""Populations by name: published riders, a value file with standard errors and correlations, or a range of one
value."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from fmus.declaration.component import Component
from fmus.support.errors import InputError, unknown
from motofmi.identification.population import population
from motofmi.studies.population import Distribution, LogNormal, Uniform, of_component, of_sample
from motofmi.workflows.components import component
from motofmi.workflows.measured_rider import VALUES
from rider_fmu import riders
from rider_fmu.rigs.handlebar import HANDLEBAR_INERTIA

# A rider's inertia at the bar is measured together with that of the bar, and may be zero without it.
OFFSETS = {"added_steer_inertia": HANDLEBAR_INERTIA}
PUBLISHED: Mapping[str, Sequence[str]] = {
    "riders_2011": [f"{number}_2011" for number in range(1, 11)],
    "riders_2008": [f"{number}_2008" for number in range(1, 6)],
}
RIDER = "rider"  # the name of a population of whole riders; any other name is a parameter


@dataclass(frozen=True)
class RiderPopulation:
    """A rider whose parameters are replaced by those of a member, and the distribution of the members."""

    component: Component
    distribution: LogNormal


def rider_population(name: str) -> RiderPopulation:
    """The riders of a published table by name, or those of a measured rider's value file (.toml).

    Raises InputError for any other name, and for a file without standard errors.
    """
    if name in PUBLISHED:
        members = [riders.load(member) for member in PUBLISHED[name]]
        found = population(members, VALUES, OFFSETS)
        offsets = np.array([OFFSETS.get(parameter, 0.0) for parameter in found.names])
        return RiderPopulation(members[0], of_sample(found, offsets))
    if Path(name).suffix != ".toml":
        raise InputError(f"{unknown('population', name, PUBLISHED)}, or the .toml of a measured rider")
    measured = component(name)
    offsets_of_rider = {n: offset for n, offset in OFFSETS.items() if n in measured.values}
    return RiderPopulation(measured, of_component(measured, offsets_of_rider))


def uniform(name: str, text: str, unit: str) -> Distribution:
    """A parameter between the two values of `A:B`. Raises InputError for text of another form."""
    try:
        low, high = (float(part) for part in text.split(":"))
    except ValueError:
        raise InputError(f"{name}~{text} is neither a range A:B nor a population: write {name}~0.08:0.12, or "
                         f"{RIDER}~NAME with a population of riders "
                         f"({', '.join(PUBLISHED)}, FILE.toml)") from None  # fmt: skip
    if not (np.isfinite([low, high]).all() and low < high):
        raise InputError(f"{name}~{text}: expected two finite values, the lower one first")
    return Uniform((name,), (unit,), low, high)
