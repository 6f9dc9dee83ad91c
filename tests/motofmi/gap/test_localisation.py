"""Where a model misses: no false places in noise, and the places of what is hidden, by two ways of seeing."""

from dataclasses import replace

import numpy as np
import pytest

from motofmi.gap.criteria import Criteria
from motofmi.gap.estimation.fitting import fit
from motofmi.gap.experiments.input_output import input_output_experiment
from motofmi.gap.localisation.harmonic_places import cells
from motofmi.gap.localisation.locating import discovered, locate
from motofmi.gap.localisation.sampled_places import cells as of_samples
from motofmi.gap.models.harmonic_model import HarmonicModel
from motofmi.gap.preprocessing.harmonics import noise_of, variance_of
from motofmi.gap.preprocessing.sampled_run_preparation import prepare_sampled_run
from motofmi.gap.preprocessing.steer_test_run import prepare_steer_test_run
from motofmi.recordings.recording import Recording
from motofmi.reports.gap_map import gap_map
from motofmi.workflows import components
from motofmi.workflows.gap.rig import rig_experiment

pytest.importorskip("numba", reason="the simulator of the hidden effects is compiled by numba")
from tests.simulators.as_recordings import as_recording
from tests.simulators.hidden_rig import RIDER, Rig, record, stepped, sweep
from tests.simulators.rig_runs import RIG

EVEN, ODD = (2, 4, 6), (3, 5, 7)


def made(hidden=None, excitation=None, seed=0):
    arrays = record(excitation or sweep(0.5, 12, 2, 100.0), hidden or {}, RIDER, np.random.default_rng(seed), Rig())
    return prepare_steer_test_run(as_recording("run", arrays), "steer_angle", "steer_torque", "steer_angle_command")


def base_of(*runs):
    model = HarmonicModel(rig_experiment(RIG))
    return fit(model, runs, model.start())


def noisy(run, rng, added=0.0):
    """The run with nothing in it but noise and what is added (n,): data over a noise that is estimated from it."""
    n, rate = len(run.recording.time), run.recording.rate
    slow = np.fft.irfft(np.fft.rfft(rng.standard_normal(n)) / (1 + (np.fft.rfftfreq(n, 1 / rate) / 2) ** 2), n)
    y = 0.4 * slow / slow.std() + 0.2 * rng.standard_normal(n)
    noise, data = noise_of(run.reduction, y), run.reduction.reduce(y + added)
    return replace(
        run,
        outputs=(replace(run.effort, noise=noise, deviation=np.sqrt(variance_of(run.reduction, noise)), data=data),),
    )


@pytest.mark.study
@pytest.mark.parametrize("excitation", [sweep(0.5, 12, 2, 100.0), stepped(0.5, 8.5, 0.5, 4, 10.0)])
def test_noise_has_no_places(excitation):
    run, rng = made(excitation=excitation), np.random.default_rng(1)
    found = [list(cells(each, each.data / each.deviation)) for each in (noisy(run, rng) for _ in range(120))]
    assert len(found[0]) > 60
    # At 1 % of 120 runs, four and more with a false place are seen once in 30 such tests.
    assert sum(bool(discovered(places, Criteria().false_discovery_rate)) for places in found) <= 3
    p_values = np.array([p.p_value for places in found for p in places])
    # Cells of a run overlap: 120 x 25 of them are independent at most; at 1 % their share scatters by 0.002.
    assert np.mean(p_values < 0.01) < 0.01 + 4 * 0.002


@pytest.mark.slow
@pytest.mark.parametrize(("hidden", "lit", "dark"), [
    ({"ra": 0.01}, EVEN[:1], ODD),  # |d| has even harmonics, beside those that the base makes of itself
    ({"Tc": 0.15}, ODD[:2], EVEN),  # friction has odd ones
    ({"rd": 0.15}, (1,), EVEN + ODD),  # what drifts slowly has none
])  # fmt: skip
def test_orders_of_what_is_hidden(hidden, lit, dark):
    places = locate(base_of(made(hidden)), cells)
    orders = {p.order for p in places if p.order}
    assert set(lit) <= orders and not orders & set(dark)
    assert any(p.axis == "direction" and p.unit == "1" for p in places) == bool(set(lit) & set(EVEN))


@pytest.mark.slow
def test_a_drift_is_where_the_rider_changed_most():
    """The base takes the mean of a linear drift, whose ends then are ten times as far from it as the parts beside the
    middle."""

    def wandering(t):  # to and fro, so that a base that errs at a frequency errs at all times
        cycles = 4.5 * t - 20 / (2 * np.pi) * np.cos(2 * np.pi * t / 20)
        return np.radians(2) * np.clip(np.minimum(t, 100 - t), 0, 1.0) ** 3 * np.sin(2 * np.pi * cycles)

    found = base_of(made({"rd": 0.6}, (wandering, 100.0)))
    times = {p.start: p.excess for p in locate(found, cells, Criteria(false_discovery_rate=1.0)) if p.axis == "time"}
    excess = [times[t] for t in sorted(times)]
    assert min(excess[0], excess[-1]) > 3 * max(excess[3:5])  # noise alone scatters by 0.3 in an eighth of the run


@pytest.mark.slow
@pytest.mark.parametrize(("unit", "signal"), [("rad", 0), ("rad/s", 1)])
@pytest.mark.parametrize("side", [1, -1])
def test_what_happens_to_one_side_is_seen_there(unit, signal, side):
    """Bumps that last a fifth of a cycle, at the largest angle or rate of one sign."""
    run = made()
    motion = run.motion_at(run.recording.time)[signal]
    share = side * motion / np.sqrt(np.convolve(motion**2, np.ones(640) / 640, "same") * 2)
    bumps = noisy(run, np.random.default_rng(2), 2.0 * np.maximum(share - 0.8, 0))
    places = [p for p in cells(bumps, bumps.data / bumps.deviation) if p.axis == "direction" and p.unit == unit]
    there, elsewhere = sorted(places, key=lambda p: -side * (p.start + p.end))
    assert there.p_value < 1e-20 and there.excess > 4 * max(elsewhere.excess, 0)


@pytest.mark.slow
def test_directions_share_the_residuals():
    """Both halves together hold as many numbers, and as much power, as the whole: they are parts of one rotation."""
    run = made()
    z = np.random.default_rng(3).standard_normal(len(run.data))
    every = list(cells(run, z))
    whole = next(p for p in every if p.axis == "run")
    for unit in ("rad", "rad/s"):
        halves = [p.excess + 1 for p in every if p.axis == "direction" and p.unit == unit]
        # the mean of two chi-squares of about n / 2 each, over their numbers: n / 2 to within 2 % of n
        assert np.mean(halves) == pytest.approx(whole.excess + 1, rel=0.02)


@pytest.mark.slow
def test_rising_and_falling_frequency_and_amplitudes_are_distinguished():
    both = sweep(1, 9, 2, 60.0)[0]

    def there_and_back(t):
        return np.where(t < 60, both(np.minimum(t, 60)), 2 * both(np.maximum(120 - t, 0)))

    run = made(excitation=(there_and_back, 120.0))
    late = np.concatenate(
        [np.full(basis.shape[1], first > 60 * run.recording.rate) for first, _, basis in run.reduction.bases]
    )
    z = np.random.default_rng(4).standard_normal(len(run.data)) + 2 * late
    clear = {
        (p.axis, p.unit, np.sign(p.start + p.end))
        for p in discovered(list(cells(run, z)), Criteria().false_discovery_rate)
    }
    assert ("direction", "Hz/s", -1.0) in clear and ("direction", "Hz/s", 1.0) not in clear
    amplitudes = [p for p in cells(run, z) if p.axis == "amplitude"]
    assert amplitudes[0].p_value > 1e-3 and amplitudes[-1].p_value < 1e-20


@pytest.mark.slow
def test_the_map_marks_what_was_found():
    found = base_of(made({"Tc": 0.3}))
    missed = locate(found, cells)
    over_time, _, orders, *_ = gap_map(found, missed).panels
    marked = [p for p in missed if p.axis == "time"]
    assert len(over_time.shades) == len(marked) > 0
    assert {round(shade.low, 6) for shade in over_time.shades} == {round(p.start, 6) for p in marked}
    assert sum(orders.cells.framed) == len([p for p in missed if p.axis == "frequency" and p.order])


@pytest.mark.slow
def test_directions_of_sampled_runs():
    """A free choice of excitation: chances are those of noise, and bumps on one side are seen there."""
    time = np.arange(3000) / 100.0
    rng = np.random.default_rng(5)
    force = np.sin(2 * np.pi * 0.7 * time) + 0.6 * np.sin(2 * np.pi * 1.9 * time + 1)
    position = 0.01 * np.convolve(force, np.exp(-np.arange(60) / 15), "same") + 1e-5 * rng.standard_normal(len(time))
    recording = Recording("run", time, {"force": force, "displacement": position}, {"force": "N", "displacement": "m"})
    run = prepare_sampled_run(
        recording, input_output_experiment(components.component("mass_spring_damper"), ["force", "displacement"])
    )
    chances = []
    for _ in range(60):
        z = rng.standard_normal(len(run.data))
        chances += [p.p_value for p in of_samples(run, z) if p.axis == "direction"]
    # 240 chances, halves of each other apart: 0.1 to within four times (0.1 0.9 / 120)^0.5
    assert len(chances) == 240 and abs(np.mean(np.array(chances) < 0.1) - 0.1) < 4 * 0.027
    middle = np.median(position)
    for sign, unit in ((1, "m"), (-1, "m")):
        bumps = 5.0 * (sign * (position - middle) > 0.8 * np.max(sign * (position - middle)))
        places = [
            p
            for p in of_samples(run, z + run.reduction.reduce(bumps[:, None]))
            if p.axis == "direction" and p.unit == unit
        ]
        there, elsewhere = sorted(places, key=lambda p: -sign * (p.start + p.end))
        assert there.p_value < 1e-10 and there.excess > 4 * max(elsewhere.excess, 0)


def test_places_by_amplitude_are_those_of_the_motion_although_another_output_has_another_unit():
    time = np.arange(3000) / 100.0
    force, phase = np.sin(4 * time), 4 * time - 1
    columns = {"force": force, "displacement": 0.03 * np.sin(phase), "velocity": 0.12 * np.cos(phase)}
    columns |= {n: columns[n] * (1 + 0.01 * time) for n in ("displacement", "velocity")}
    recording = Recording("run", time, columns, {"force": "N", "displacement": "m", "velocity": "m/s"})
    run = prepare_sampled_run(
        recording, input_output_experiment(components.component("mass_spring_damper"), list(columns))
    )
    found = [p for p in of_samples(run, np.ones(len(run.data))) if p.axis == "amplitude"]
    assert found and {p.unit for p in found} == {"m"}
    assert max(p.end for p in found) < 0.04  # 0.03 m that grow by 30 %; the velocity exceeds 0.12 m/s
