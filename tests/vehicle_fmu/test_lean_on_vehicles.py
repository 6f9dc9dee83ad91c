"""The rider in roll as an effect of a vehicle: the same motorcycle as with him as a device, and named by the gap
workflow.
"""

import csv
import json

import numpy as np
import pytest

from fmus import linearise
from motofmi.cli.main import main
from motofmi.workflows import components, listing
from rider_fmu import riders
from rider_fmu.effects_on_vehicles.lean import RiderInRollLeans
from vehicle_fmu import modes, motorcycles, over_speed, ridden

WHOLE = motorcycles.load("sharp_1971")
LEANT = WHOLE.with_effects(RiderInRollLeans())
HIDDEN = ridden(WHOLE, riders.load("roll_1971"))


def farthest(found, expected):
    """The largest distance from an expected eigenvalue to the nearest found one, relative."""
    return max(np.abs(found - e).min() / max(abs(e), 1.0) for e in expected)


@pytest.mark.slow
@pytest.mark.parametrize("speed", [3.0, 20.0, 50.0])
def test_a_whole_rider_as_an_effect_is_the_rider_as_a_device(speed):
    effect = np.linalg.eigvals(linearise(LEANT.with_values(**{"rider_lean.share": 1.0}), speed=speed).A)
    device = np.linalg.eigvals(linearise(HIDDEN, **{"vehicle.speed": speed}).A)
    assert len(effect) == len(device)
    assert farthest(effect, device) < 1e-11  # rounding of two eigensolutions


@pytest.mark.slow
def test_no_share_of_him_leaves_the_motorcycle_and_half_of_him_lies_between():
    plain = np.linalg.eigvals(linearise(WHOLE, speed=30.0).A)
    weave = {}
    for share in (0.0, 0.5, 1.0):
        vehicle = LEANT.with_values(**{"rider_lean.share": share})
        weave[share] = modes(over_speed(ridden(vehicle)), [30.0])["weave"].eigenvalue[0].real
        if not share:
            assert farthest(np.linalg.eigvals(linearise(vehicle, speed=30.0).A), plain) < 1e-11
    assert sorted(weave.values()) in ([weave[s] for s in (0.0, 0.5, 1.0)], [weave[s] for s in (1.0, 0.5, 0.0)])


@pytest.mark.slow
def test_stiff_joints_give_the_rigid_rider_back():
    """Ten times the frequencies: the error falls as one over the stiffness."""
    plain = np.linalg.eigvals(linearise(WHOLE, speed=30.0).A)
    errors = [
        farthest(
            np.linalg.eigvals(
                linearise(LEANT.with_values(**{"rider_lean.share": 1.0, "rider_lean.quickness": q}), speed=30.0).A
            ),
            plain,
        )
        for q in (2.5, 5.0)
    ]
    assert errors[1] < errors[0] / 2


def test_it_is_listed_and_offered_to_motorcycles_alone():
    assert ("rider_lean", "pelvis_torso_head") in {(e["name"], e["form"]) for e in listing.effects()}
    assert (
        RiderInRollLeans in components.EFFECTS["Motorcycle"]
        and RiderInRollLeans not in components.EFFECTS["PassiveRider"]
    )


def measured(path, speeds, error, rng):
    """Weave and wobble of the hidden motorcycle with a leaning rider, as somebody measures them."""
    found = modes(over_speed(HIDDEN), speeds)
    with path.open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(["speed [m/s]", "mode", "real [1/s]", "imag [1/s]", "real_se [1/s]", "imag_se [1/s]"])
        for mode in ("weave", "wobble"):
            for speed, value in zip(speeds, found[mode].eigenvalue, strict=True):
                real, imag = rng.normal((value.real, value.imag), error)
                writer.writerow([speed, mode, real, imag, error, error])
    return str(path)


@pytest.mark.study
def test_the_gap_workflow_names_the_rider_who_leans(tmp_path, capsys):
    rng = np.random.default_rng(0)
    fitted = measured(tmp_path / "fitted.csv", np.arange(12.0, 50.0, 3.0), 0.1, rng)
    held = measured(tmp_path / "held.csv", np.arange(13.0, 50.0, 4.0), 0.1, rng)
    assert main(["gap", fitted, "--vehicle", "sharp_1971", "--holdout", held, "--out", str(tmp_path / "gap")]) == 0
    capsys.readouterr()
    verdict = json.loads((tmp_path / "gap" / "verdict.json").read_text())
    (effect,) = verdict["effects"]
    assert (verdict["verdict"], effect["name"], effect["form"]) == ("named", "rider_lean", "pelvis_torso_head")
    for parameter in effect["parameters"].values():  # all three are one in what was hidden
        assert abs(parameter["value"] - 1) < 3.5 * parameter["standard_error"]
    # The motorcycle's own data are known to a few percent only, and the leaning rider is what the data ask for.
    assert verdict["gap"]["holdout_after"] < 1.6 < 3 < verdict["gap"]["holdout_before"]
