"""A vehicle given by its matrices: the benchmark bicycle's printed ones, and files that cannot be used."""

import numpy as np
import pytest

import motofmi as mf
from fmus import InputError, linearise
from fmus.effects.library import applicable_effects
from motofmi.workflows import components
from motofmi.workflows.components import VEHICLE_EFFECTS
from vehicle_fmu import motorcycles
from vehicle_fmu.components.given_matrices import STATES, from_matrices

# Meijaard, Papadopoulos, Ruina, Schwab, Proc. R. Soc. A 463 (2007) 1955-1982, eqs 5.4 to 5.7.
M = np.array([[80.81722, 2.31941332208709], [2.31941332208709, 0.29784188199686]])
K0 = np.array([[-80.95, -2.59951685249872], [-2.59951685249872, -0.80329488458618]])
K2 = np.array([[0, 76.59734589573222], [0, 2.65431523794604]])
C1 = np.array([[0, 33.86641391492494], [-0.85035641456978, 1.68540397397560]])


def matrices():
    zero, one = np.zeros((2, 2)), np.eye(2)
    B = np.linalg.inv(M)
    return {"A0": np.block([[zero, one], [-B @ (9.81 * K0), zero]]), "A1": np.block([[zero, zero], [zero, -B @ C1]]),
            "A2": np.block([[zero, zero], [-B @ K2, zero]]), "B": np.vstack([zero, B])}  # fmt: skip


def written(folder, **changed):
    text = "\n".join(f"{n} = {np.asarray(x).tolist()}" for n, x in {**matrices(), **changed}.items() if x is not None)
    (folder / "benchmark.toml").write_text(text + '\nsource = "Meijaard et al. 2007"\n')
    return folder / "benchmark.toml"


@pytest.mark.slow
def test_the_benchmark_bicycles_matrices_have_its_printed_eigenvalues(tmp_path):
    vehicle = components.vehicle(str(written(tmp_path)))
    eigenvalues = np.linalg.eigvals(linearise(vehicle, speed=5.0).A)
    for printed in (-14.07838969, -0.77534188 + 4.46486771j, -0.32286643):
        assert np.abs(eigenvalues - printed).min() < 1e-8  # the digits that are printed


def test_matrices_and_bicycle_answer_torques_alike(tmp_path):
    given, bicycle = (
        linearise(v, speed=4.0) for v in (from_matrices(written(tmp_path)), motorcycles.load("benchmark_bicycle"))
    )
    for space in (given, bicycle):
        assert set(STATES) == set(space.states)
    for state in STATES:
        for torque in ("roll_torque", "steer_torque"):
            one, other = (s.B[s.states.index(state), s.inputs.index(torque)] for s in (given, bicycle))
            assert one == pytest.approx(other, rel=1e-9, abs=1e-12)  # the digits that are printed


def test_effects_act_on_torques_and_inertias(tmp_path):
    vehicle = from_matrices(written(tmp_path))
    families = {e.family for e in applicable_effects(vehicle, VEHICLE_EFFECTS)}
    assert {"coulomb_friction", "steer_damping", "steer_stiffness", "added_inertia", "roll_inertia"} <= families
    damped = vehicle.with_effects(*(e() for e in applicable_effects(vehicle, VEHICLE_EFFECTS) if e.family == "steer_damping")).with_values(
        **{"steer_damping.damping": 2.0}
    )
    bicycle = motorcycles.load("benchmark_bicycle", steering_damping=2.0)
    one, other = (np.sort_complex(np.linalg.eigvals(linearise(v, speed=4.0).A)) for v in (damped, bicycle))
    assert one == pytest.approx(other, rel=1e-8)


@pytest.mark.parametrize("changed, expected", [
    ({"A0": np.zeros((4, 4))}, "upper rows"), ({"B": np.zeros((4, 2))}, "singular"), ({"A0": [[1, 2], [3, 4]]}, "4 rows of 4"),
    ({"A3": np.zeros((4, 4))}, "unknown key 'A3'"), ({"B": None}, "no B"), ({"A1": [["x"] * 4] * 4}, "finite numbers"),
])  # fmt: skip
def test_a_file_that_cannot_be_used_is_refused_with_its_fault(tmp_path, changed, expected):
    with pytest.raises(InputError, match=expected):
        from_matrices(written(tmp_path, **changed))


@pytest.mark.parametrize("damping", [0.0, 2.0])
def test_what_measured_eigenvalues_show_beside_the_matrices_is_named(tmp_path, damping):
    """Weave of the benchmark bicycle with a steering damper; the matrices have no free parameter."""
    rng, error, rows = np.random.default_rng(2), 0.02, ["speed [m/s],mode,real [1/s],imag [1/s],real_se [1/s],imag_se [1/s]"]
    steering = np.diag([0.0, damping])
    for v in np.arange(4.5, 9.1, 0.5):
        A = np.block([[np.zeros((2, 2)), np.eye(2)],
                      [-np.linalg.solve(M, 9.81 * K0 + v**2 * K2), -np.linalg.solve(M, v * C1 + steering)]])  # fmt: skip
        weave = max(np.linalg.eigvals(A), key=lambda x: x.imag) + error * (rng.normal() + 1j * rng.normal())
        rows.append(f"{v},weave,{weave.real:.5f},{weave.imag:.5f},{error},{error}")
    (tmp_path / "weave.csv").write_text("\n".join(rows))
    found = mf.find_gap(tmp_path / "weave.csv", vehicle=str(written(tmp_path)))
    assert [e["name"] for e in found.effects] == ["steer_damping"] * bool(damping)
    assert found.verdict == ("named" if damping else "none")
    if damping:
        value = found.effects[0]["parameters"]["damping"]
        assert value["value"] == pytest.approx(damping, abs=4 * value["standard_error"])
