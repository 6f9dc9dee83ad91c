"""Doubtful recordings: they are read as they are, with a warning."""

import json

import numpy as np
import pytest

from fmus.support.errors import InputError
from motofmi.frequency_response.estimators import estimate
from motofmi.recordings.quality import channel_warnings
from motofmi.recordings.reading import read_recording
from motofmi.recordings.recording import Recording
from motofmi.recordings.rig_file import read_rig
from tests.motofmi.recordings.test_recordings import good, text, warned

RATE = 128.0


def test_dropped_samples_are_counted(write):
    lines = text(good())
    del lines[1000:1003], lines[400]
    recording = warned(write(lines), "4 samples missing in 2 gaps", f"first at {398 / RATE:g} s")
    assert len(recording.time) == 2556  # nothing is filled in
    assert any("bridged" in w for w in estimate(recording).warnings)


def test_many_missing_samples_are_refused_by_the_estimate(write):
    lines = text(good())
    del lines[1000:1200]
    with pytest.raises(InputError, match="200 of 2560 samples are missing"):
        estimate(read_recording(write(lines)))


def test_duplicate_time_stamps(write):
    lines = text(good())
    lines.insert(300, lines[300])
    warned(write(lines), "1 duplicate time stamps", f"{299 / RATE:g} s")


def test_jitter(write):
    recording = good()
    jittery = recording.time + 0.05 / RATE * np.random.default_rng(1).standard_normal(len(recording.time))
    warned(write(text(Recording("", jittery, recording.columns, recording.units))), "jitter", "%")


def test_clipping(write):
    recording = good()
    limit = 0.8 * np.abs(recording["steer_torque"]).max()
    clipped = np.clip(recording["steer_torque"], -limit, limit)
    columns = {**recording.columns, "steer_torque": clipped}
    first = recording.time[np.argmax(clipped == limit)]
    warned(
        write(text(Recording("", recording.time, columns, recording.units))),
        "clipped at its upper limit",
        f"first at {first:g} s",
    )


@pytest.mark.parametrize(("share", "called"), [(0.5, False), (0.2, True)])
def test_a_command_between_two_levels_is_not_called_clipped(share, called):
    """A random binary command, and one that is ramped between its levels most of the time."""
    time = np.arange(4000) / RATE
    levels = np.repeat(np.random.default_rng(2).choice([-1.0, 1.0], 40), 100)
    held = np.arange(4000) % 100 < 200 * share
    ramped = np.where(held, levels, levels * (1 - np.random.default_rng(3).uniform(0, 1, 4000)))
    found = channel_warnings(time, {"fan": levels if share == 0.5 else ramped}, {"fan": "V"})
    assert any("clipped" in each for each in found) == called


@pytest.mark.parametrize("step", [0.0, 0.0002, 0.002])
def test_quantised_sine_is_not_called_clipped(write, step):
    recording = good()
    if step:
        recording.columns["steer_angle"][:] = step * np.round(recording["steer_angle"] / step)
    assert read_recording(write(text(recording))).warnings == ()


def test_swapped_channels(write):
    warned(write(text(good(), "time [s],steer_torque [N.m],steer_angle [rad]")), "steer_angle reaches", "swapped")


def test_wrong_rate(write, tmp_path):
    (tmp_path / "rig.json").write_text(json.dumps({"sampling": {"value": 128, "unit": "Hz"}}))
    warned(write(text(good(rate=100.0))), "100 Hz", "rig.json says 128 Hz")


@pytest.mark.parametrize("channel", ["steer_angle", "steer_torque"])
def test_flipped_sign(channel):
    recording = good()
    assert estimate(recording).warnings == ()
    flipped = {**recording.columns, channel: -recording[channel]}
    assert any("sign" in w for w in estimate(Recording("", recording.time, flipped, recording.units)).warnings)


def test_rig_json(tmp_path):
    assert read_rig(tmp_path) == {}
    (tmp_path / "rig.json").write_text('{"handlebar_inertia": {"value": 125, "standard_error": 1, "unit": "g.m2"}}')
    entry = read_rig(tmp_path)["handlebar_inertia"]
    assert entry == {"value": 0.125, "standard_error": 0.001, "unit": "kg.m2"}
    (tmp_path / "rig.json").write_text('{"handlebar_inertia": {"value": 0.125}}')
    with pytest.raises(InputError, match="found no 'unit'"):
        read_rig(tmp_path)
    (tmp_path / "rig.json").write_text('{"handlebar_inertia": 0.125}')
    with pytest.raises(InputError, match=r'"handlebar_inertia": \{"value"'):
        read_rig(tmp_path)


def test_time_in_the_wrong_unit(write):
    """Milliseconds called seconds: 128 Hz look like 0.128 Hz."""
    recording = good()
    slow = Recording("", 1000 * recording.time, recording.columns, recording.units)
    with pytest.raises(InputError, match=r"sampled at 0.128 Hz, nothing from 0.5 to 12 Hz"):
        estimate(read_recording(write(text(slow))))


@pytest.mark.parametrize("ends", [(True, True), (True, False), (False, True)])
def test_a_machine_at_rest_at_the_ends_is_not_called_clipped(write, ends):
    """A staircase of torques, and an angle whose largest value is that at rest."""
    recording = good()
    count = len(recording.time)
    moving = np.ones(count)
    moving[: count // 5 * ends[0]] = moving[count - count // 5 * ends[1] :] = 0
    recording.columns["steer_angle"][:] = -moving * (1.001 + np.sin(7 * recording.time)) * 0.05
    recording.columns["steer_torque"][:] = 2.0 * np.round(np.sin(0.7 * recording.time))
    assert not any("clipped" in warning for warning in read_recording(write(text(recording))).warnings)


def test_a_quantised_signal_that_is_clipped_is_called_so(write):
    recording = good()
    angle = 0.05 * np.sin(2 * np.pi * 0.5 * recording.time)
    recording.columns["steer_angle"][:] = 0.0005 * np.round(np.minimum(angle, 0.04) / 0.0005)
    warned(write(text(recording)), "steer_angle seems clipped at its upper limit 0.04 rad")


@pytest.mark.parametrize(("command_varies", "called"), [(False, False), (True, True)])
def test_a_speed_that_has_settled_under_a_constant_command_is_not_called_clipped(command_varies, called):
    """A coarse tachometer that alternates between two levels at the end of a step response; with a command that varies
    meanwhile its highest level is a limit."""
    time = np.arange(0, 4, 0.002)
    speed = 4 * np.round(15 * (1 - np.exp(-np.maximum(time - 1, 0) / 0.05))) - 4.0 * (np.arange(len(time)) % 7 == 0)
    command = np.where(time < 1, 0.0, 2.0) + 0.1 * command_varies * np.sin(20 * time)
    found = channel_warnings(time, {"speed": speed, "command": command}, {"speed": "rad/s", "command": "V"})
    assert any("speed seems clipped at its upper limit" in warning for warning in found) == called


@pytest.mark.parametrize(("commands", "limit", "called"), [
    (np.tile([0.3, 1.0, 0.1, 0.4, 0.2], 6), np.inf, False),
    (np.sin(np.arange(60) / 3), 0.7, True),
])  # fmt: skip
def test_a_slowly_sampled_position_at_rest_is_not_called_clipped(commands, limit, called):
    """20 samples at each command, which the position reaches after three; a stop holds it over several commands."""
    command = np.repeat(commands, 20)
    reached = np.concatenate([command[:3], command[:-3]])
    position = np.minimum(np.convolve(reached, np.ones(3) / 3, "same"), limit)
    found = channel_warnings(np.arange(len(command)) / 10, {"position": position, "command": command},
                             {"position": "rad", "command": "rad"})  # fmt: skip
    assert any("position seems clipped at its upper limit" in warning for warning in found) == called
