"""The gap workflow on free decays, from the exact solution of the damped oscillator: without a force only ratios show.

x(t) = x0 e^(-z w t) (cos w_d t + z w / w_d sin w_d t),   w^2 = k / m,   2 z w = c / m,   w_d = w sqrt(1 - z^2)
"""

import json

import numpy as np
import pytest

import motofmi as mf
from fmus import Component, parameter, state
from fmus.mechanisms import DrivenJoint, MassSpringDamper
from fmus.support.errors import InputError
from motofmi.cli.main import main
from motofmi.gap.experiments.input_output import input_output_experiment
from motofmi.gap.models.free_initial_state import FreeInitialStateModel
from motofmi.recordings.reading import write_recording
from motofmi.recordings.recording import Recording
from motofmi.workflows.gap.input_output import anchored
from tests import as_study

STIFFNESS, DAMPING = 720.0, 6.0  # of a mass of 1 kg


def decay(name: str, released: float, seed: int) -> Recording:
    w, zw = np.sqrt(STIFFNESS), DAMPING / 2
    wd = np.sqrt(w**2 - zw**2)
    time = np.arange(0, 20, 1 / 128)
    x = released * np.exp(-zw * time) * (np.cos(wd * time) + zw / wd * np.sin(wd * time))
    noise = 2e-4 * np.random.default_rng(seed).standard_normal(len(time))
    return Recording(name, time, {"displacement": x + noise}, {"displacement": "m"})


@pytest.mark.slow
@pytest.mark.parametrize(
    "free", [as_study(("spring_stiffness", "spring_damping")), ("mass", "spring_stiffness", "spring_damping")]
)
def test_of_a_free_decay_one_value_stays_and_the_others_are_found(tmp_path, free, capsys):
    for name, released in (("fit", 0.035), ("held", 0.02)):
        write_recording(decay(name, released, len(name)), tmp_path / f"{name}.csv")
    fit, held = (str(tmp_path / f"{name}.csv") for name in ("fit", "held"))
    assert (
        main(
            [
                "gap",
                fit,
                "--component",
                "mass_spring_damper",
                "--free",
                *free,
                "--holdout",
                held,
                "--out",
                str(tmp_path / "out"),
            ]
        )
        == 0
    )
    result = json.loads((tmp_path / "out" / "verdict.json").read_text("utf-8"))
    assert result["verdict"] == "none"
    assert any("with mass as given" in sentence for sentence in result["limitations"])
    assert set(result["base"]) == {"spring_stiffness", "spring_damping"}
    for name, exact in (("spring_stiffness", STIFFNESS), ("spring_damping", DAMPING)):
        found = result["base"][name]
        assert abs(found["value"] - exact) < 4 * found["standard_error"]  # once in 16,000
        assert found["standard_error"] < 0.02 * exact


def test_what_anchors_the_scale_of_all_forces():
    test = input_output_experiment(DrivenJoint(), ["angle"])
    fewer, kept = anchored(test)
    assert (kept, [f.name for f in fewer.free]) == ("inertia", ["damping", "stiffness"])
    held = input_output_experiment(MassSpringDamper(), ["displacement"], free=["spring_damping"])
    assert anchored(held) == (held, "mass and spring_stiffness")


class Chamber(Component):
    """A chamber that leaks to the surroundings, whose pressure is the zero of the gauge."""

    leakage = parameter("1/s", "Rate of the leak", min=0, start=0.01)
    supply = parameter("Pa/s", "Supply of a pump")
    pressure = state("Pa", "Pressure", exposed=True, start=1e5)

    def equations(self, v, m):
        return {"der(pressure)": v.supply - v.leakage * v.pressure}


def test_a_decay_to_a_pressure_that_the_component_does_not_have_is_said(monkeypatch):
    """p = 7.49e5 + 1.6e4 exp(-0.02 t) Pa; without the constant the component falls to a third in the 140 s."""
    time = np.arange(0, 140, 0.2)
    noise = 50 * np.random.default_rng(6).standard_normal(len(time))
    recording = Recording("leak", time, {"pressure": 7.49e5 + 1.6e4 * np.exp(-0.02 * time) + noise}, {"pressure": "Pa"})
    found = mf.find_gap(recording, component=Chamber())
    assert found.verdict == "none"
    (said,) = [s for s in found.limitations if "is compared up to a constant" in s]
    assert any(s.startswith("supply is 0 in Chamber and is not fitted") for s in found.limitations)
    offset = float(said.split("plus ")[1].split(" Pa")[0])
    assert offset == pytest.approx(7.49e5, rel=2e-3)  # three printed digits

    def diverges(*_):
        raise InputError("the simulation diverges")

    monkeypatch.setattr(FreeInitialStateModel, "offsets_of_outputs", diverges)  # after a verdict it is no error
    assert not any("is compared up to a constant" in s for s in mf.find_gap(recording, component=Chamber()).limitations)
