"""Hands on the handlebar as an effect on vehicles; the truth is the rider of the 2011 paper beside Kane's equations."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import motofmi as mf
from fmus import InputError, linearise, local, parameter
from fmus.composition.value_files import Library
from fmus.effects.library import applicable_effects
from fmus.interfaces.handlebar import HandlebarDevice
from motofmi.cli.main import main
from motofmi.gap.estimation.fit_result import parameters_of
from motofmi.gap.preprocessing.eigenvalues import read_eigenvalues
from motofmi.gap.selection.eigenvalues import select_model_for_eigenvalues
from motofmi.workflows.components import VEHICLE_EFFECTS
from motofmi.workflows.device_effects import device_effects
from motofmi.workflows.gap.vehicle import vehicle_effects, vehicle_experiment, with_mode_names
from rider_fmu import COMPONENTS as RIDER_COMPONENTS
from rider_fmu import riders
from tests import as_study
from tests.simulators.hidden_vehicle import SHARP, matrix, spectrum
from vehicle_fmu import GivenMatrices, motorcycles

SPEEDS = np.arange(12.0, 57.1, 3.0)
ERROR = 0.05  # 1/s
SYMBOLS = {"added_steer_inertia": "I_a", "torso_inertia": "I_t", "arm_stiffness": "k_a", "waist_stiffness": "k_t",
           "arm_damping": "c_a", "waist_damping": "c_t"}  # fmt: skip


def hidden(name: str) -> dict:
    values = riders.load(name).values
    return {"hands": {symbol: values[n] for n, symbol in SYMBOLS.items()}}


def effect(family: str, form: str):
    return next(e for e in VEHICLE_EFFECTS if (e.family, e.form) == (family, form))


def table(path: Path, rider: str, modes: tuple[str, ...], heading: str = "imag [rad/s]", factor: float = 1.0) -> Path:
    """Eigenvalues of Sharp's motorcycle with a published rider, as measured."""
    rng = np.random.default_rng(0)
    lines = [f"speed [m/s],mode,real [1/s],{heading},real_se,{heading.replace('imag', 'imag_se')}"]
    for mode in modes:
        for speed, x in zip(SPEEDS, spectrum(SHARP, SPEEDS, hidden(rider))[mode], strict=True):
            real, imag = np.array([x.real, x.imag]) + ERROR * rng.standard_normal(2)
            lines.append(f"{speed},{mode},{real},{factor * imag},{ERROR},{factor * ERROR}")
    path.write_text("\n".join(lines))
    return path


def verdict_on(path: Path):
    vehicle = motorcycles.load("sharp_1971")
    experiment = vehicle_experiment(vehicle)
    run = with_mode_names(read_eigenvalues(path), experiment)
    return select_model_for_eigenvalues(experiment, [run], vehicle_effects(vehicle, linear=True))


@pytest.mark.slow
@pytest.mark.parametrize("rider", ["mean_2011", "10_2011"])
def test_the_rider_as_an_effect_is_the_rider_of_the_paper_on_the_motorcycle(rider):
    vehicle = motorcycles.load("sharp_1971").with_effects(effect("passive_rider", "torso")())
    values = {f"passive_rider.{n}": riders.load(rider).values[n] for n in SYMBOLS}
    own = np.sort_complex(np.linalg.eigvals(linearise(vehicle.with_values(**values), speed=30.0).A))
    assert own == pytest.approx(np.sort_complex(np.linalg.eigvals(matrix(SHARP, 30.0, hidden(rider)))), rel=1e-8)


@pytest.mark.slow
def test_an_inerter_as_an_effect_is_that_of_its_equation():
    vehicle = motorcycles.load("sharp_1971").with_effects(effect("steer_damping", "inerter")())
    own = np.sort_complex(np.linalg.eigvals(linearise(vehicle, speed=30.0).A))
    assert own == pytest.approx(
        np.sort_complex(np.linalg.eigvals(matrix(SHARP, 30.0, {"inerter": (0.1, 7.5)}))), rel=1e-8
    )


@pytest.mark.slow
@pytest.mark.parametrize("rider, modes", [as_study("mean_2011", ("weave", "wobble")), ("mean_2011", ("weave",)),
                                          ("3_2011", ("weave", "rider_wobble"))])  # fmt: skip
def test_hands_on_the_bar_are_named_and_their_values_found(tmp_path, rider, modes):
    verdict = verdict_on(table(tmp_path / "eigenvalues.csv", rider, modes))
    assert verdict.verdict == "named" and [c.family for c in verdict.effects] == ["passive_rider"]
    found = parameters_of(verdict.best)
    for name, truth in riders.load(rider).values.items():
        if name in SYMBOLS:
            value, error, _ = found[f"vehicle.passive_rider.{name}"]
            assert abs(value - truth) < 3 * error, name  # one in 370 lies beyond
    # The data determine some of the six parameters, the riders of 2011 the others.
    effect, best = verdict.effects[0].effect, verdict.best
    assert 2 < best.effective_parameters(effect) < 6
    # Errors of the model make the values less certain, and leave the shares of data and prior in them.
    uncertain = replace(best, sandwich=4 * best.covariance())
    assert uncertain.effective_parameters(effect) == best.effective_parameters(effect)


@pytest.mark.slow
def test_hands_on_the_bar_are_named_with_eigenvalues_for_validation(tmp_path):
    """Half of the speeds are for validation; the values of the rider are those of the fitted ones."""
    rows = table(tmp_path / "all.csv", "mean_2011", ("weave", "wobble")).read_text().splitlines()
    for name, chosen in (("fitted", rows[1::2]), ("held", rows[2::2])):
        (tmp_path / f"{name}.csv").write_text("\n".join([rows[0], *chosen]))
    found = mf.find_gap(tmp_path / "fitted.csv", validation=tmp_path / "held.csv", vehicle="sharp_1971")
    assert found.verdict == "named" and [e["name"] for e in found.effects] == ["passive_rider"]
    before, after = (found.to_dict()["gap"][name] for name in ("holdout_before", "holdout_after"))
    assert after < 2 < 0.1 * before  # reduced chi-square: that of the noise for more than twenty times as much


@pytest.mark.slow
@pytest.mark.parametrize("heading, factor", [("imag [1/s]", 1.0), ("imag", 1.0), ("imag (rad/s)", 1.0), ("imag [Hz]", 0.5 / np.pi), ("imag [deg/s]", 180 / np.pi)])  # fmt: skip
def test_imaginary_parts_are_read_in_their_units(tmp_path, heading, factor):
    expected = read_eigenvalues(table(tmp_path / "a.csv", "mean_2011", ("weave",)))
    given = read_eigenvalues(table(tmp_path / "b.csv", "mean_2011", ("weave",), heading, factor))
    assert given.value == pytest.approx(expected.value) and given.imag_error == pytest.approx(expected.imag_error)


def test_a_real_part_in_hertz_is_refused(tmp_path):
    rows = "\n".join(["10,weave,-1,20,0.1,0.1"] * 5)
    (tmp_path / "a.csv").write_text(f"speed,mode,real [Hz],imag,real_se,imag_se\n{rows}")
    with pytest.raises(InputError, match="no unit of a real part"):
        read_eigenvalues(tmp_path / "a.csv")


def test_every_damper_and_rider_at_the_handlebar_is_a_candidate_found_by_its_file(tmp_path):
    class SpringAtTheBar(HandlebarDevice):
        """A spring between handlebar and frame."""

        stiffness = parameter("N.m/rad", "Stiffness", min=0, start=1.0)
        spring_torque = local("N.m", "Torque of the spring")

        def equations(self, v, m):
            v.spring_torque = -v.stiffness * v.steer_angle
            return {"handlebar_torque": v.spring_torque, "frame_torque": -v.spring_torque}

    (tmp_path / "soft.toml").write_text('component = "SpringAtTheBar"\nsource = "a test"\n[parameters]\nstiffness = 20.0')
    (found,) = device_effects(Library("spring", tmp_path, {"SpringAtTheBar": SpringAtTheBar}))
    assert (found.family, found.free_parameters()) == ("spring_at_the_bar", ("stiffness",))
    assert found.prior.median == pytest.approx(20.0)
    vehicle = motorcycles.load("sharp_1971")
    assert applicable_effects(vehicle, [found]) == [found]
    families = {(e.family, e.form) for e in vehicle_effects(vehicle)}
    assert {("passive_rider", "torso"), ("steer_damping", "linear"), ("steer_damping", "progressive")} <= families
    assert len(families) == len(vehicle_effects(vehicle))


def test_the_prior_of_a_rider_is_the_population_of_the_ten_and_a_further_file_of_their_source_joins_it(tmp_path):
    (rider,) = device_effects(Library("rider", riders.folder, {"PassiveRider": RIDER_COMPONENTS["PassiveRider"]}))
    ten = np.array([[riders.load(f"{k}_2011").values[n] for n in rider.prior.names] for k in range(1, 11)])
    mean, deviation = (ten + rider.prior.offset).mean(axis=0), ten.std(axis=0, ddof=1)
    # The log-normal distribution with the mean and the deviation of the sample, widened as the sample is small.
    narrow = np.log1p((deviation / mean) ** 2)
    assert rider.prior.mean == pytest.approx(np.log(mean) - narrow / 2)
    assert np.diag(rider.prior.covariance) == pytest.approx(narrow * 11 * 9 / (10 * 2))
    for name in riders.names():
        (tmp_path / f"{name}.toml").write_text((riders.folder / f"{name}.toml").read_text("utf-8"), "utf-8")
    (tmp_path / "11_2011.toml").write_text((riders.folder / "2_2011.toml").read_text("utf-8"), "utf-8")
    (more,) = device_effects(Library("rider", tmp_path, {"PassiveRider": RIDER_COMPONENTS["PassiveRider"]}))
    assert len(more.prior.sample) == 11


def test_a_vehicle_without_a_handlebar_port_has_no_device_as_effect():
    with pytest.raises(InputError, match="no handlebar port"):
        GivenMatrices("matrices").with_effects(effect("passive_rider", "torso")())


@pytest.mark.study
def test_the_command_writes_the_rider_by_itself_and_the_modes_with_him(tmp_path):
    path = table(tmp_path / "eigenvalues.csv", "mean_2011", ("weave", "wobble"))
    assert main(["gap", str(path), "--vehicle", "sharp_1971", "--out", str(tmp_path / "gap")]) == 0
    verdict = json.loads((tmp_path / "gap" / "verdict.json").read_text("utf-8"))
    assert [e["name"] for e in verdict["effects"]] == ["passive_rider"]
    assert (tmp_path / "gap" / verdict["fmu"]).exists() and (tmp_path / "gap" / verdict["device"]["fmu"]).exists()
    there = {label: verdict["modes"][label]["rider_wobble"]["frequency"] for label in ("before", "after")}
    assert np.isfinite(np.array(there["after"], float)).all() and not np.isfinite(np.array(there["before"], float)).any()
    rider = tmp_path / "gap" / verdict["device"]["path"]
    out = tmp_path / "modes.json"
    assert main(["modes", "--vehicle", "sharp_1971", "--device", str(rider), "--speed", "30", "--json", str(out)]) == 0
    weave = complex(*json.loads(out.read_text("utf-8"))["modes"]["weave"]["eigenvalue"][0])
    # The vehicle as given and the fitted rider: the weave is moved by the errors of both, a few of one measurement.
    assert abs(weave - spectrum(SHARP, np.array([20.0, 30.0]), hidden("mean_2011"))["weave"][1]) < 5 * ERROR
