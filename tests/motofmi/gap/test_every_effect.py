"""Every effect that the workflow knows of the rider is hidden by a simulator written apart, and found again with its size."""

import pytest

from motofmi.gap.estimation.fit_result import parameters_of
from motofmi.gap.models.harmonic_model import HarmonicModel
from motofmi.gap.selection.model_selection import select_model
from motofmi.workflows.gap.rig import rig_effects, rig_experiment

pytest.importorskip("numba", reason="the simulator of the hidden effects is compiled by numba")
import numpy as np

from tests.simulators.hidden_rig import RIDER, Rig, record, sweep
from tests.simulators.rig_runs import RIG, library, prepared, runs_of

# Hidden values by the simulator's names; family and parameter by the library's. Strengths of delta chi-square 300 and
# more.
HIDDEN = [
    ({"Tc": 0.5}, "coulomb_friction", "friction_torque", 0.5),
    ({"k3": 8e3}, "hardening_stiffness", "cubic_stiffness", 8e3),
    ({"g": 8e-4}, "backlash", "half_gap", 8e-4),
    ({"c2": 0.5}, "progressive_damping", "coefficient", 0.5),
    ({"Fh": 1.0, "wh": 0.01}, "hysteresis", "force", 1.0),
    ({"ra": 0.03}, "asymmetry", "ratio", 0.03),
    ({"rd": 0.3}, "drift", "ratio", 0.3),
    ({"rj": 0.2}, "drift", "ratio", 0.2 / 1.1),  # of the mean stiffness
    (
        {"re": 0.5},
        "drift",
        "ratio",
        0.5 * 0.9817 / (1 + 0.5 * 0.7546),
    ),  # over the run, of the mean stiffness: integrals of exp(-4 t / T)
    ({"kr": 25.0, "tau": 0.12}, "reflex", "gain", 25.0),
    ({"td": 0.005}, "channel_delay", "delay", 0.005),
    ({"C": 1e-4}, "shaft_compliance", "compliance", 1e-4),
    ({"C": 1.5e-5}, "shaft_compliance", "compliance", 1.5e-5),  # less than a hundredth of the bar's own impedance
    ({"Ih": 0.07, "fh": 4.0, "zh": 0.25}, "extra_mode", "inertia", 0.07),
    ({"km": 500.0, "tm": 0.08}, "viscoelastic_arm", "series_stiffness", 500.0),
    ({"Tw": 1.0}, "waist_friction", "friction_torque", 1.0),
    ({"g3": 0.03}, "sensor_nonlinearity", "cubic_gain", 0.03),
    ({"J": 0.05}, "added_inertia", "inertia", 0.05),
    ({"Icc": 0.1}, "cross_inertia", "inertia", 0.1),
    ({"ks": 40.0}, "steer_stiffness", "stiffness", 40.0),
    ({"cs": 1.5}, "steer_damping", "damping", 1.5),
]


# Each is looked for among its like, which is what takes it for another; the whole library competes in
# benchmarks.gap_blind.
NOT_LINEAR = {
    "coulomb_friction",
    "hardening_stiffness",
    "backlash",
    "progressive_damping",
    "hysteresis",
    "asymmetry",
    "waist_friction",
    "sensor_nonlinearity",
}


@pytest.mark.slow
@pytest.mark.study
@pytest.mark.parametrize(
    ("hidden", "family", "parameter", "value"),
    HIDDEN,
    ids=[f"{row[1]}_{next(iter(row[0]))}_{row[3]:.2g}" for row in HIDDEN],
)
def test_it_is_found_again(hidden, family, parameter, value):
    runs = runs_of(hidden, sweep(0.5, 12, 2, 70.0), sweep(12, 0.5, 3.5, 70.0))
    library = [e for e in rig_effects() if (e.family in NOT_LINEAR) == (family in NOT_LINEAR) and not e.flexible]
    verdict = select_model(HarmonicModel(rig_experiment(RIG)), runs, library)
    if verdict.verdict == "tied":
        # Linear effects at one port part by little; the truth is among them.
        assert family in [c.family for c in verdict.tied]
        return
    assert [c.family for c in verdict.effects] == [family]
    known = parameters_of(verdict.best)
    found, error, _ = next(v for n, v in known.items() if n.endswith(f"{family}.{parameter}"))
    # 5 %, or three standard errors: of 18 effects one would be beyond two by chance
    assert abs(found) == pytest.approx(value, abs=max(0.05 * value, 3 * error))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("growths", "form", "parameter", "value"),
    [((4e-3, 4e-3), "growing", "growth", 4e-3), ((3.5e-3, 5e-3), "skew", "skew", 5e-5)],
)
def test_a_delay_that_grows_by_as_much_in_every_run_is_no_clock_that_is_fast(growths, form, parameter, value):
    """A buffer that fills, or two clocks: runs of 70 and 100 s distinguish them."""
    rng = np.random.default_rng(3)
    excitations = sweep(0.5, 12, 2, 70.0), sweep(12, 0.5, 3.5, 100.0)
    made = {
        f"run_{i}": record(excitation, {"te": growths[i]}, RIDER, rng, Rig())
        for i, excitation in enumerate(excitations)
    }
    verdict = select_model(
        HarmonicModel(rig_experiment(RIG)), prepared(made), library("channel_delay", "shaft_compliance")
    )
    assert [(c.family, c.effect.form) for c in verdict.effects] == [("channel_delay", form)]
    found, error, _ = next(
        v for n, v in parameters_of(verdict.best).items() if n.endswith(f"channel_delay.{parameter}")
    )
    assert found == pytest.approx(value, abs=3 * error) and error < 0.05 * value
