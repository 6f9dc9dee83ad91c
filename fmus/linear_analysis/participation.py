"""Which unit takes part in which mode.

    p_ik = |w_ik v_ik| / sum_i |w_ik v_ik|

v_k the right and w_k the left eigenvector of A x = lambda x: how much of the mode lives in state i. The participation
of a unit is the sum over its states. It does not depend on the units in which the states are measured. Source:
Perez-Arriaga, Verghese, Schweppe, IEEE Trans. Power Apparatus Syst. 101 (1982) 3117-3125.
"""

import numpy as np

from fmus.linear import StateSpace


def participation(space: StateSpace) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Eigenvalues (n,) with Im >= 0, the slowest first [1/s], and each unit's share in them (n,), from states `unit.state`."""
    eigenvalues, right = np.linalg.eig(space.A)
    shares = np.abs(np.linalg.inv(right).T * right)
    shares /= shares.sum(axis=0)
    kept = np.flatnonzero(eigenvalues.imag >= 0)
    kept = kept[np.argsort(np.abs(eigenvalues[kept]))]
    owner = [state.partition(".")[0] for state in space.states]
    units = {name: np.array([o == name for o in owner]) for name in dict.fromkeys(owner)}
    return eigenvalues[kept], {name: shares[mine][:, kept].sum(axis=0) for name, mine in units.items()}
