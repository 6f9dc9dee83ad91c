"""Planning of a steer test: the magnitude from which each effect would be detected and named by planned runs."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from fmus.effects import Effect, load_folder
from fmus.support.errors import InputError, unknown
from fmus.support.files import writable, write_atomically, write_text
from fmus.support.notebook import html, new_axes
from fmus.support.plain_json import to_json
from motofmi.frequency_response.excitation import Excitation, sweep
from motofmi.gap.criteria import Criteria
from motofmi.gap.estimation.fitting import fit
from motofmi.gap.experiment_design.detectable_effects import detectable_effects
from motofmi.gap.experiment_design.planned_run import Channels, planned
from motofmi.gap.models.harmonic_model import HarmonicModel
from motofmi.recordings.channels import TORSO_RATE
from motofmi.recordings.rig_file import read_rig
from motofmi.reports.plan_figure import draw_plan, plan_chart, plan_figure
from motofmi.reports.shown import Interactive
from motofmi.workflows.gap.rig import GYRO_NOISE, rig_effects, rig_experiment

FILE, PICTURE = "plan.json", "plan.png"
# Default standard deviations: deg, N.m, N.m (below REMNANT_BAND), rad/s
NOISE = {"angle": 0.03, "torque": 0.2, "remnant": 0.4, "gyro": GYRO_NOISE}
REMNANT_BAND = 2.0  # Hz; corner frequency of the rider's remnant torque
HEADINGS = ("effect", "form", "parameter", "detected from", "named from", "unit", "nearest rival")


@dataclass(frozen=True, repr=False)
class Plan:
    """The effects that planned runs would detect and name; `plan_experiment` shows an example.

    effects holds for every effect and form: its magnitude parameter, the values `noticed_from` and `named_from` [unit]
    from which it would be detected and named (None if never), the nearest rival, and the effects that are tied with it
    at any magnitude. noise holds the standard deviations of angle [deg], torque [N.m], remnant [N.m, below 2 Hz] and
    gyro [rad/s]; amplitude is in rad, duration in s.
    """

    rider: str
    runs: Sequence[Mapping[str, Any]]
    amplitude: float
    duration: float
    gyro: bool
    noise: Mapping[str, float]
    effects: Sequence[Mapping[str, Any]]

    @property
    def rows(self) -> list[tuple[str, ...]]:
        """The effects as rows of text, under HEADINGS."""
        return [(e["name"], e["form"], e["parameter"], _magnitude(e["noticed_from"]), _magnitude(e["named_from"]),
                 e["unit"],
                 ", ".join(e["tied"]) or e["nearest_rival"]) for e in self.effects]  # fmt: skip

    def to_dict(self) -> dict[str, Any]:
        """The keys of `motofmi gap --plan --json`."""
        return {"rider": self.rider, "amplitude": self.amplitude, "duration": self.duration, "gyro": self.gyro,
                "runs": list(self.runs), "noise": dict(self.noise), "effects": list(self.effects)}  # fmt: skip

    def to_dataframe(self) -> Any:
        """The effects as a pandas.DataFrame."""
        import pandas  # noqa: PLC0415 - imported on use

        return pandas.DataFrame(list(self.effects))

    def save(self, folder: str | Path) -> list[Path]:
        """Write plan.json and plan.png into the folder and return their paths. Raises InputError where it cannot be
        written."""
        folder = Path(folder)
        write_text(writable(folder / FILE), to_json({**self.to_dict(), "picture": PICTURE}) + "\n")
        write_atomically(
            folder / PICTURE, partial(plan_figure(self.effects).savefig, dpi=130, metadata={"Software": None})
        )
        return [folder / FILE, folder / PICTURE]

    def plot(self, axes: Any = None) -> Any:
        """Plot for each effect the magnitudes from which it is detected and named; returns the matplotlib axes."""
        return draw_plan(new_axes(figsize=(7, 0.25 * len(self.effects) + 1)) if axes is None else axes, self.effects)

    def show(self) -> Interactive:
        """The magnitudes from which effects are named, interactive in a notebook."""
        return Interactive(plan_chart(self.effects), "Planned steer test")

    def __repr__(self) -> str:
        named = sum(e["named_from"] is not None for e in self.effects)
        return (
            f"Plan({len(self.runs)} runs of {self.duration:g} s at {np.degrees(self.amplitude):g} deg: {named} of "
            f"{len(self.effects)} forms of effects could be named)"
        )

    def _repr_html_(self) -> str:
        return html(repr(self), HEADINGS, self.rows)


def plan_experiment(rig: str | Path | Mapping[str, Any] | None = None,
                    excitations: Sequence[Excitation | tuple[float, float]] = ((0.5, 12.0),), *,
                    rider: str = "mean_2011", amplitude: float = np.radians(2.0), duration: float = 200.0,
                    sampling: float = 128.0, gyro: bool = False, noise: Mapping[str, float] | None = None,
                    effects: str | Path | Sequence[type[Effect]] = (),
                    criteria: Criteria = Criteria()) -> Plan:  # fmt: skip
    """The effects that a planned steer test would detect and name, with this rig and noise.

    rig is a rig.json or its contents; excitations are the planned runs: an Excitation, or (from, to) [Hz] for a sweep
    of `duration` [s] and `amplitude` [rad]. rider names the published rider that is expected. sampling is in Hz; gyro
    adds a rate gyro on the torso. noise replaces the standard deviation of angle [deg], torque [N.m], remnant [N.m,
    below 2 Hz] or gyro [rad/s]. effects is a folder of own effects, or their classes; criteria are the thresholds of
    all decisions.

    Raises InputError for a rig file that does not exist, and for an unknown or negative noise.

        >>> plan = mf.plan_experiment(excitations=[(0.5, 12.0)], duration=20.0)
        >>> plan
        Plan(1 runs of 20 s at 2 deg: ... forms of effects could be named)
        >>> sorted(plan.effects[0])[:3], len(plan.rows) == len(plan.to_dataframe())
        (['form', 'name', 'named_from'], True)
        >>> plan.to_dict()["runs"]
        [{'from': 0.5, 'to': 12.0}]
        >>> axes, page = plan.plot(), plan.show().save("plan.html")
        >>> [path.name for path in plan.save("plan")]
        ['plan.json', 'plan.png']
    """
    if rig is not None and not isinstance(rig, Mapping) and not Path(rig).exists():
        raise InputError(f"cannot read {rig}: no such file")
    experiment = rig_experiment(rig if isinstance(rig, Mapping) else read_rig(rig) if rig is not None else {}, rider)
    deviations = {**NOISE, "gyro": experiment.further[TORSO_RATE].noise, **(noise or {})}
    for name, value in deviations.items():
        if name not in NOISE:
            raise unknown("noise", name, NOISE)
        if not value >= 0:
            raise InputError(f"noise of {name} is {value:g}: a standard deviation cannot be negative")
    model = HarmonicModel(experiment)
    motions = [each if isinstance(each, Excitation) else sweep(*each, duration, amplitude) for each in excitations]
    channels = Channels(
        sampling,
        float(np.radians(deviations["angle"])),
        _density(deviations, sampling),
        {TORSO_RATE: deviations["gyro"]} if gyro else {},
    )
    runs = [
        planned(e, channels, experiment.columns, lambda run: model.outputs(run, model.start(), slopes=False)[0], seed)
        for seed, e in enumerate(motions)
    ]
    library = rig_effects(load_folder(effects) if isinstance(effects, str | Path) else effects)
    found = detectable_effects(fit(model, runs, model.start()), library, criteria)
    return Plan(rider, [{"excitation": e.name} if isinstance(e, Excitation) else {"from": e[0], "to": e[1]}
                        for e in excitations], float(amplitude),
                duration, gyro, deviations,
                [{"name": n.effect.family, "form": n.effect.form, "parameter": n.parameter, "unit": n.unit,
                  "noticed_from": n.detected, "named_from": n.named, "nearest_rival": n.rival, "tied": list(n.tied)}
                 for n in found])  # fmt: skip


def _density(noise: Mapping[str, float], rate: float) -> Callable[[np.ndarray], np.ndarray]:
    """Spectral density of the torque noise as a variance per sample [(N.m)2]: white noise plus the low-pass remnant."""
    gain = rate / 2 / REMNANT_BAND / (np.pi / 4)  # so that the remnant's density integrates to its variance

    def density(f: np.ndarray) -> np.ndarray:
        return noise["torque"] ** 2 + noise["remnant"] ** 2 * gain / (1 + (f / REMNANT_BAND) ** 2) ** 2

    return density


def _magnitude(value: float | None) -> str:
    return "never" if value is None else f"{value:.3g}"
