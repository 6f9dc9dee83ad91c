"""One eigenvalue for each mode where the roots of several modes form pairs with each other."""

import numpy as np
import pytest

from fmus.linear_analysis.linearisation import StateSpace
from vehicle_fmu.mode_curves import mode_curves
from vehicle_fmu.mode_shapes import ModeShapes

STATES = ("vehicle.steer_rate", "vehicle.steer_angle", "vehicle.rear_relaxed_slip", "vehicle.lateral_velocity", "vehicle.roll_rate")


def spectrum(*blocks):
    """The shapes of a block-diagonal system, and its eigenvalues in the order of its states."""
    A = np.zeros((1, len(STATES), len(STATES)))
    k = 0
    for block in map(np.atleast_2d, blocks):
        A[0, k : k + len(block), k : k + len(block)] = block
        k += len(block)
    n = len(STATES)
    space = StateSpace(A, np.zeros((1, n, 1)), np.zeros((1, 1, n)), np.zeros((1, 1, 1)), STATES, ("u",), ("y",))
    values = np.linalg.eigvals(A).astype(complex)
    return ModeShapes.of(space, values), values


@pytest.mark.parametrize("wobble, rear", [((0, 2), (1, 3)), ((0, 3), (1, 2)), ((1, 2), (3, 0))])
def test_crosswise_pairs_go_to_the_modes_whose_states_move_in_them(wobble, rear):
    shapes, values = spectrum([[-3.0, 2.0], [-2.0, -3.0]], [[-7.0, 5.0], [-5.0, -7.0]], -1.0)
    own = np.zeros((3, 1, 5), bool)
    own[0, 0, list(wobble)] = own[1, 0, list(rear)] = own[2, 0, 4] = True
    typical = np.array([[[0.6, 0.3, 0.1, 0, 0], [0.1, 0, 0.5, 0.4, 0], [0, 0, 0, 0, 1]]])
    curves = mode_curves(values, own, lambda at: shapes, lambda at: typical)
    assert curves[:, 0] == pytest.approx([-3 + 2j, -7 + 5j, -1])  # the blocks' own: a +- b i
    exchanged = mode_curves(values, own, lambda at: shapes, lambda at: typical[:, [1, 0, 2]])
    assert exchanged[:, 0] == pytest.approx([-7 + 5j, -3 + 2j, -1])


def test_one_crosswise_pair_leaves_each_mode_its_other_root():
    shapes, values = spectrum([[-3.0, 2.0], [-2.0, -3.0]], -7.0, -9.0, -1.0)
    own = np.zeros((2, 1, 5), bool)
    own[0, 0, [0, 2]] = own[1, 0, [1, 3]] = True
    assert mode_curves(values, own, lambda at: shapes, lambda at: np.ones((1, 2, 5)))[:, 0] == pytest.approx([-7, -9])


def test_a_mode_without_an_eigenvalue_of_its_own_is_absent():
    shapes, values = spectrum([[-3.0, 2.0], [-2.0, -3.0]], -7.0, -9.0, -1.0)
    own = np.zeros((2, 1, 5), bool)
    own[0, 0, 0] = own[1, 0, 1] = True
    typical = np.array([[[1.0, 1, 0, 0, 0], [0, 0, 1, 0, 0]]])
    found = mode_curves(values, own, lambda at: shapes, lambda at: typical)[:, 0]
    assert found[0] == pytest.approx(-3 + 2j) and np.isnan(found[1])
