"""An imposed sine: inertia and stiffness are not both identifiable, so the inertia keeps its value."""

import numpy as np
import pytest

from fmus.mechanisms import MassSpringDamper
from motofmi.gap.experiments.input_output import input_output_experiment
from motofmi.gap.preprocessing.sampled_run_preparation import prepare_sampled_run
from motofmi.gap.selection.any_component import investigate
from motofmi.recordings.recording import Recording

MASS, STIFFNESS, DAMPING, AMPLITUDE = 2.0, 5000.0, 300.0, 0.01


def imposed(frequencies):
    rng = np.random.default_rng(0)
    time, w = np.arange(0, 10, 0.005), 2 * np.pi * np.array(frequencies)[:, None]
    phase = w * np.arange(0, 10, 0.005) + np.arange(len(w))[:, None]
    x, v, a = (AMPLITUDE * np.sum(part, axis=0) for part in (np.sin(phase), w * np.cos(phase), -(w**2) * np.sin(phase)))
    force = MASS * a + DAMPING * v + STIFFNESS * x
    columns = {"displacement": x, "force": force + 0.01 * force.std() * rng.standard_normal(len(time))}
    return Recording("sine", time, columns, {"displacement": "m", "force": "N"})


@pytest.mark.slow
@pytest.mark.parametrize("frequencies", [[2.0], [2.0, 9.0]])
def test_the_mass_is_fitted_only_where_it_shows(frequencies):
    recording = imposed(frequencies)
    test = input_output_experiment(
        MassSpringDamper(mass=1.0, spring_stiffness=4000.0, spring_damping=200.0),
        list(recording.columns),
        "displacement",
    )
    found = investigate(test, [prepare_sampled_run(recording, test)])
    values = found.verdict.best.model.values(found.verdict.best.shared)
    assert found.verdict.verdict == "none"
    if len(frequencies) == 1:
        assert found.fixed_inertias == ("mass",) and values["mass"] == 1.0
        # The stiffness is then that at the frequency: k - (m - 1 kg) w^2; noise of 1 % in 2000 samples leaves 0.03 %
        assert values["spring_stiffness"] == pytest.approx(STIFFNESS - (MASS - 1.0) * (4 * np.pi) ** 2, rel=2e-3)
    else:
        assert found.fixed_inertias == ()
        assert values["mass"] == pytest.approx(MASS, rel=0.02)
        assert values["spring_stiffness"] == pytest.approx(STIFFNESS, rel=0.02)
