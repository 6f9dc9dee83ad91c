"""The noise floor of one-step predictions: the errors of a long regression on everything recorded before.

    y_k = sum_l (Y_l y_k-l + U_l u_k-l) + U_0 u_k + nonlinear features of k-1 and k-2 + e_k

U_0 = 0 for inputs that are held. With enough lags the errors e_k are those of the true system, for any linear system
and any disturbance with a smooth spectrum, under feedback too. Gains that change with the speed, and friction at an
element, are among the features. A model with errors of the same size has a reduced chi-square of 1.

Source: Ljung, Wahlberg, Adv. Appl. Probab. 24 (1992) 412-440, on long regressions.
"""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from fmus.support.errors import InputError
from motofmi.gap.preprocessing.flexible_noise_model import Density
from motofmi.gap.preprocessing.predicted_run import PredictedRun

LAGS = (10, 20, 40)  # samples; the number of lags with the least value of Akaike's criterion is used
BANDS = 12  # bands of the errors' spectrum
NONLINEAR_LAGS = (1, 2)  # samples
VARYING_SPEED = 0.02  # relative range of the speed from which the gains may change with it


def with_best_prediction(run: PredictedRun, inputs: np.ndarray, features: Sequence[np.ndarray]) -> PredictedRun:
    """The run with the error spectra of the best prediction from inputs (n, nu) and nonlinear features (n,) each.

    Raises InputError where the run has too few samples for the fewest lags.
    """
    best, errors, scale = np.inf, np.zeros_like(run.measured), 1.0
    for lags in reversed(LAGS):  # the fewest last: where none can be used, the error states their numbers
        tried, count, used = _regression_errors(run, inputs, features, lags)
        if used <= 2 * count:
            continue
        covariance = np.cov(tried[~np.isnan(tried[:, 0])].T).reshape(run.measured.shape[1], -1)
        criterion = used * float(np.linalg.slogdet(covariance)[1]) + 2 * count * tried.shape[1]
        if criterion < best:
            best, errors, scale = criterion, tried, used / (used - count)
    if not np.isfinite(best):
        raise InputError(
            f"{run.name}: {used} samples are too few for the noise of its predictions, which needs more than "
            f"{2 * count}. Record longer runs, or with a higher sampling rate."
        )
    taken = np.nan_to_num(errors)
    within = taken[run.compared]
    mixing = np.linalg.inv(np.linalg.cholesky(within.T @ within / len(within)))
    flat = run.with_floor(mixing, [Density(np.array([0.0, 1.0]), np.ones(2))] * len(mixing))
    edges = np.unique(np.linspace(0, len(run.frequency), BANDS + 1).astype(int))
    middle = np.array([run.frequency[a:b].mean() for a, b in pairwise(edges)])
    power = flat.cosines(taken) ** 2 * scale
    return run.with_floor(
        mixing, [Density(middle, np.array([p[:, a:b].mean() for a, b in pairwise(edges)])) for p in power]
    )


def _regression_errors(
    run: PredictedRun, inputs: np.ndarray, features: Sequence[np.ndarray], lags: int
) -> tuple[np.ndarray, int, int]:
    """The errors (n, ny), NaN outside of the intervals, and the numbers of features and of samples."""
    y = run.measured
    speeds, place, share = run.speeds
    errors = np.full_like(y, np.nan)
    rows, targets, spans = [], [], []
    nonlinear = np.column_stack(features) if len(features) else np.zeros((len(y), 0))
    for first, last in run.intervals:
        centre = [each[first:last] - each[first:last].mean(axis=0) for each in (y, inputs, nonlinear)]
        # A held input acts after its sample; under feedback it depends on the present error.
        input_ages = range(run.exactly_held, lags + 1)
        past = [
            each[lags - back : last - first - back]
            for each, ages in zip(centre, (range(1, lags + 1), input_ages, NONLINEAR_LAGS), strict=True)
            for back in ages
        ]
        row = np.hstack(past)
        if len(speeds) > 1 and np.ptp(speeds) > VARYING_SPEED * speeds.mean():
            speed = ((place + share) / (len(speeds) - 1) - 0.5)[first + lags : last, None]
            row = np.hstack([row, speed * row, speed**2 * np.hstack(past[:2])])
        rows.append(np.hstack([row, np.ones((len(row), 1))]))
        targets.append(centre[0][lags:])
        spans.append((first + lags, last))
    matrix, target = np.concatenate(rows), np.concatenate(targets)
    scale = np.linalg.norm(matrix, axis=0) + 1e-300
    gains, _, rank, _ = np.linalg.lstsq(matrix / scale, target, rcond=1e-10)
    residual = target - matrix / scale @ gains
    for (first, last), part in zip(spans, np.split(residual, np.cumsum([len(t) for t in targets])[:-1]), strict=True):
        errors[first:last] = part
    return errors, int(rank), len(target)
