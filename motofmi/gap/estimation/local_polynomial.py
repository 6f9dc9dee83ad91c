"""The frequency response of recorded outputs to recorded inputs without a parametric model.

    Y(k + r) = (G_0 + G_1 r + G_2 r^2) U(k + r) + T_0 + T_1 r + T_2 r^2,   r = -n to n

U and Y are discrete Fourier transforms, T is the transient (leakage). G_0 is the response at line k.

Source: Pintelon, Schoukens, System Identification, 2nd ed. (2012), ch. 7 (local polynomial method).
"""

from dataclasses import dataclass

import numpy as np

DEGREE = 2  # of the polynomials
CENTRES = 60  # lines, equally spaced on a logarithmic axis
RANK = 1e-8  # relative singular value below which the inputs do not distinguish their responses


@dataclass(frozen=True)
class Response:
    """Responses (m, ny, nu) at angular frequencies (m,) [rad/s], and their standard deviations."""

    omega: np.ndarray
    response: np.ndarray
    deviation: np.ndarray


def local_polynomial_response(omega: np.ndarray, inputs: np.ndarray, outputs: np.ndarray) -> Response | None:
    """The response from spectra (lines, nu) and (lines, ny) at angular frequencies (lines,); None with too few
    lines."""
    lines, nu = inputs.shape
    terms = (DEGREE + 1) * (nu + 1)
    half = terms  # 2 n + 1 lines for n unknowns
    if lines < 2 * half + 1:
        return None
    centres = np.unique(np.geomspace(1, lines, CENTRES).astype(int) - 1)
    found, deviations = [], []
    for centre in centres:
        first = int(np.clip(centre - half, 0, lines - 2 * half - 1))
        rows = slice(first, first + 2 * half + 1)
        r = (np.arange(first, first + 2 * half + 1) - centre) / half
        powers = r[:, None] ** np.arange(DEGREE + 1)
        columns = [powers * inputs[rows, j, None] for j in range(nu)]
        design = np.column_stack([*columns, powers])
        scale = np.linalg.norm(design, axis=0) + 1e-300
        u, size, vt = np.linalg.svd(design / scale, full_matrices=False)
        kept = size > RANK * size[0]
        inverse = (vt[kept].conj().T / size[kept]) @ u[:, kept].conj().T / scale[:, None]
        solution = inverse @ outputs[rows]
        left = outputs[rows] - design @ solution
        freedom = max(len(r) - int(np.count_nonzero(kept)), 1)
        noise = np.sqrt(np.sum(np.abs(left) ** 2, axis=0) / freedom)
        places = np.arange(nu) * (DEGREE + 1)
        found.append(solution[places].T)
        deviations.append(noise[:, None] * np.linalg.norm(inverse[places], axis=1))
    return Response(omega[centres], np.array(found), np.array(deviations))
