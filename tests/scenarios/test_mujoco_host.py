"""MuJoCo as a host: a handlebar with the rider, against the one linear system."""

import pytest

from motofmi.scenarios.hosts import (
    mujoco_bar,
)
from tests.simulators.held_torques import relative_errors

STEP = 1e-3


class TestMujoco:
    def test_modes_are_those_of_the_one_linear_system(self):
        pytest.importorskip("mujoco")
        found = mujoco_bar.run(STEP)
        # The torque between meetings is of the second order: (H |lambda|)^2 / 12 for the fastest mode, 59 1/s.
        assert max(relative_errors(found["following_torque"])) < (59 * STEP) ** 2 / 12
        assert found["following_torque"]["trajectory_error"] < (59 * STEP) ** 2 / 12
        assert found["held_torque"]["trajectory_error"] > 100 * found["following_torque"]["trajectory_error"]

    def test_the_error_falls_with_the_square_of_the_step(self):
        pytest.importorskip("mujoco")
        coarse, fine = (mujoco_bar.run(h)["following_torque"]["trajectory_error"] for h in (2 * STEP, STEP))
        # The next order adds H |lambda| = 6 % of the error at 1 ms and twice that at 2 ms.
        assert coarse / fine == pytest.approx(4, rel=0.15)

    def test_nothing_is_left_in_the_callback(self, tmp_path):
        mujoco = pytest.importorskip("mujoco")
        with pytest.raises(AttributeError):
            mujoco_bar.free_motion(
                mujoco_bar.MODEL.format(step=STEP, **mujoco_bar.SprungFrame("frame").values), 2, None
            )
        assert mujoco.get_mjcb_passive() is None
