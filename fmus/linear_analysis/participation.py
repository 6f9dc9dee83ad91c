"""Participation factors: the share of each part of a system in each mode.

    p_ik = |w_ik v_ik| / sum_i |w_ik v_ik|

v_k and w_k are the right and left eigenvectors of A x = lambda x; p_ik is the participation of state i in mode k. The
participation of a part is the sum over its states. It does not depend on the units of measurement of the states.
Source: Perez-Arriaga, Verghese, Schweppe, IEEE Trans. Power Apparatus Syst. 101 (1982) 3117-3125.
"""

import numpy as np

from fmus.linear_analysis.linearisation import StateSpace


def participation(space: StateSpace) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Eigenvalues (n,) with Im >= 0 [1/s], slowest first, and by part its participation (n,) from the states
    `part.state`.
    """
    eigenvalues, right = np.linalg.eig(space.A)
    shares = np.abs(np.linalg.inv(right).T * right)
    shares /= shares.sum(axis=0)
    kept = np.flatnonzero(eigenvalues.imag >= 0)
    kept = kept[np.argsort(np.abs(eigenvalues[kept]))]
    owner = [state.partition(".")[0] for state in space.states]
    units = {name: np.array([o == name for o in owner]) for name in dict.fromkeys(owner)}
    return eigenvalues[kept], {name: shares[mine][:, kept].sum(axis=0) for name, mine in units.items()}
