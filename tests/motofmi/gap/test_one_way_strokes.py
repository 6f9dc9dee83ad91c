"""Dry friction from strokes of one direction each, as in friction tests of robot joints and linear drives."""

from pathlib import Path

import numpy as np
import pytest

import motofmi as mf
from motofmi.recordings.reading import write_recording
from motofmi.recordings.recording import Recording
from tests.few_laws import FAMILIES, only_families

MASS, DAMPING = 2.0, 20.0  # kg, N.s/m
SPEEDS = (0.05, 0.15, 0.3)  # m/s, mean of a stroke
OFFSET = 0.5  # N


def stroke(speed: float, friction: float, seed: int, offset: float = 0.0) -> Recording:
    """10 s at 100 Hz of a displacement whose speed changes by 60 % about its mean: force with noise of 0.05 N."""
    time = np.arange(1000) / 100
    turn, share = 2 * np.pi * 0.7, 0.6
    rate = speed * (1 + share * np.sin(turn * time))
    x = speed * (time + share * (1 - np.cos(turn * time)) / turn)
    force = MASS * speed * share * turn * np.cos(turn * time) + DAMPING * rate + friction * np.sign(speed) + offset
    force += 0.05 * np.random.default_rng(seed).standard_normal(len(time))
    return Recording(f"stroke_{seed}", time, {"force": force, "displacement": x}, {"force": "N", "displacement": "m"})


def there_and_back(folder: Path, speed: float, friction: float, seed: int) -> Path:
    """A file with two strokes in opposite directions, and a pause of 3 s between them that was not recorded."""
    there, back = stroke(speed, friction, seed), stroke(-speed, friction, seed + 50)
    begin = {"force": 0.0, "displacement": float(there["displacement"][-1])}
    columns = {n: np.concatenate([there[n], begin[n] + back[n]]) for n in begin}
    both = Recording(f"both_{seed}", np.concatenate([there.time, back.time + 13.0]), columns, there.units)
    write_recording(both, folder / f"{both.name}.csv")
    return folder / f"{both.name}.csv"


SLIDE = mf.mechanism("mass_spring_damper", spring_stiffness=0.0, mass=MASS, spring_damping=DAMPING)


def gap(directions, friction, monkeypatch, offset=0.0):
    only_families(monkeypatch)
    speeds = [sign * speed for sign in directions for speed in SPEEDS]
    runs = [stroke(speed, friction, seed, offset) for seed, speed in enumerate(speeds)]
    held = [stroke(sign * 0.2, friction, 90 + sign, offset) for sign in directions]
    return mf.find_gap(runs, validation=held, component=SLIDE, impose="displacement")


@pytest.mark.parametrize(("friction", "offset"), [(0.0, 0.0), (0.0, OFFSET), (3.0, OFFSET)])
def test_strokes_in_both_directions_show_dry_friction(monkeypatch, friction, offset):
    """Beside an offset of the load cell, which is the same in all of them."""
    found = gap((1, -1), friction, monkeypatch, offset)
    assert found.verdict == ("named" if friction else "none")
    assert [e["name"] for e in found.effects] == ["coulomb_friction"] * bool(friction)
    if friction:
        value = found.effects[0]["parameters"]["friction_torque"]
        assert value["value"] == pytest.approx(friction, abs=4 * value["standard_error"])
    assert any("the effort of an imposed motion, has one offset in all of them" in each for each in found.limitations)
    said = [each for each in found.limitations if "force of every run is fitted as the recorded values plus -0.5 N" in each]
    assert len(said) == bool(offset)


def test_strokes_in_one_direction_do_not(monkeypatch):
    """A constant friction is an offset of the force there."""
    assert gap((1,), 3.0, monkeypatch, OFFSET).verdict == "none"


def test_so_do_parts_of_a_run_between_gaps(monkeypatch, tmp_path):
    """A hysteresis has the response of dry friction where no part is reversed."""
    only_families(monkeypatch, (*FAMILIES, "hysteresis"))
    runs = [there_and_back(tmp_path, speed, 3.0, seed) for seed, speed in enumerate(SPEEDS)]
    held = there_and_back(tmp_path, 0.2, 3.0, 9)
    found = mf.find_gap(runs, validation=held, component=SLIDE, impose="displacement")
    [effect] = found.effects
    assert any("displacement: the motion is never reversed." in each for each in found.limitations)
    value = effect["parameters"]["friction_torque"]
    assert effect["name"] == "coulomb_friction"
    assert value["value"] == pytest.approx(3.0, abs=4 * value["standard_error"])
