"""A linear model of an FMU from its outputs alone: the eigensystem realisation algorithm (ERA) on impulse responses.

Each input is changed for one step h and reset; the responses of the outputs, minus those without the change, are the
Markov parameters D, C Gamma, C Phi Gamma, C Phi^2 Gamma ... Their Hankel matrix has the rank of the model, and its
singular vectors give Phi, Gamma, C (Juang, Pappa, J. Guid. Control Dyn. 8 (1985) 620-627; python-control's
implementation). Inputs being held over a step, the continuous model follows from

    exp([[A, B], [0, 0]] h) = [[Phi, Gamma], [0, 1]]

The model is linearised about the FMU's start. It contains only modes that are observable from the outputs. A mode of Phi
that vanishes within one step, such as outputs that an FMU computes at its steps alone, has no continuous one: its static
gain is part of D (residualisation: Fernando, Nicholson, IEEE Trans. Autom. Control 27 (1982) 466-468).
"""

import numpy as np
from scipy.linalg import logm, schur, solve_sylvester

from fmus.cosimulation.subsystems.fmu_instance import FmuInstance
from fmus.linear_analysis.linearisation import StateSpace

STEP = 4e-3  # s: resolves motions up to some tens of Hz
LENGTH = 60  # of the Hankel matrix in steps
PULSE = 1e-3
VANISHED = 1e-6  # eigenvalues of Phi below are those of motions that end within a step
RANK = 1e-8  # singular values below this share of the largest are rounding


def era(subsystem: FmuInstance, step: float = STEP) -> StateSpace:
    """The FMU linearised about its start from the responses of a second instance; states are `state_1`, ..."""
    twin = subsystem.twin()
    try:
        responses = _impulse_responses(twin, step)
    finally:
        twin.close()
    scale = np.maximum(np.abs(responses).max(axis=(1, 2), initial=0.0), 1e-300)
    order = _rank(responses / scale[:, None, None])
    direct = responses[:, :, 0]
    if order == 0:
        return StateSpace(
            np.zeros((0, 0)),
            np.zeros((0, len(subsystem.inputs))),
            np.zeros((len(subsystem.outputs), 0)),
            direct,
            (),
            subsystem.inputs,
            subsystem.outputs,
        )
    import control  # noqa: PLC0415 - imported on use: it takes longer than the co-simulation

    model, _ = control.eigensys_realization(responses / scale[:, None, None], order, LENGTH, LENGTH)
    Phi, Gamma, C, static = _without_vanishing_modes(model.A, model.B, scale[:, None] * model.C)
    order = len(Phi)
    blocks = np.eye(order + len(subsystem.inputs))
    blocks[:order] = np.hstack([Phi, Gamma])
    rates = logm(blocks).real / step
    return StateSpace(rates[:order, :order], rates[:order, order:], C, direct + static,
                      tuple(f"state_{k + 1}" for k in range(order)), subsystem.inputs, subsystem.outputs)  # fmt: skip


def _without_vanishing_modes(
    Phi: np.ndarray, Gamma: np.ndarray, C: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Phi, Gamma and C of the modes that last for more than one step, and the static gain (ny, nu) of the others."""
    form, basis, k = schur(Phi, output="real", sort=lambda real, imag: np.hypot(real, imag) > VANISHED)
    mixed = solve_sylvester(form[:k, :k], -form[k:, k:], -form[:k, k:])  # makes the form block-diagonal
    Gamma, C = basis.T @ Gamma, C @ basis
    lasting = Gamma[:k] - mixed @ Gamma[k:]
    vanishing = C[:, :k] @ mixed + C[:, k:]
    static = vanishing @ np.linalg.solve(np.eye(len(Phi) - k) - form[k:, k:], Gamma[k:])
    return form[:k, :k], lasting, C[:, :k], static


def _impulse_responses(twin: FmuInstance, step: float) -> np.ndarray:
    """(ny, nu, n): the responses of the outputs to a change of each input over the first step,
    per unit of the input."""
    start, nu = twin.present_inputs.copy(), len(twin.inputs)
    runs = []
    for pulse in np.vstack([np.zeros(nu), PULSE * np.eye(nu)]):
        twin.restart(twin.values, twin.begin)
        rows = [twin.exchange(start + pulse).copy()]
        for k in range(2 * LENGTH + 1):
            held = np.zeros((4, nu))
            held[0] = start + (pulse if k == 0 else 0.0)
            twin.step(held, step)
            rows.append(twin.exchange(start).copy())
        runs.append(rows)
    return (np.array(runs[1:]).reshape(nu, -1, len(twin.outputs)) - runs[0]).transpose(2, 0, 1) / PULSE


def _rank(responses: np.ndarray) -> int:
    ny, nu, _ = responses.shape
    hankel = (
        np.block([[responses[:, :, i + j + 1] for j in range(LENGTH)] for i in range(LENGTH)])
        if ny * nu
        else np.zeros((0, 0))
    )
    values = np.linalg.svd(hankel, compute_uv=False) if hankel.size else np.zeros(0)
    return (
        int(np.count_nonzero(values > RANK * max(values.max(initial=0.0), 1e-300)))
        if values.max(initial=0.0) > RANK
        else 0
    )
