"""Losses on blocks and errors of values, on linear regressions that are solved again for comparison."""

import numpy as np
import pytest
from scipy.fft import dct, idct
from scipy.signal import lfilter

from motofmi.gap.comparison.band_dependence import band_dependence
from motofmi.gap.comparison.block_losses import (
    correlation_length,
    divided,
    left_out_mean_squares,
    mean_squares,
    partition,
    standard_error,
)
from motofmi.gap.comparison.closable import closed_share
from motofmi.gap.comparison.residuals import TimeResiduals
from motofmi.gap.comparison.sandwich import sandwich_covariance


def regression(columns: np.ndarray, y: np.ndarray) -> TimeResiduals:
    """A least-squares fit as residuals of one run with one output."""
    x = np.linalg.lstsq(columns, y, rcond=None)[0]
    return TimeResiduals(
        [(columns @ x - y)[:, None]], [columns[:, None, :]], np.ones(1), np.zeros((0, columns.shape[1]))
    )


def test_a_block_left_out_is_predicted_by_the_others():
    random = np.random.default_rng(1)
    columns, y = random.normal(size=(120, 3)), random.normal(size=120)
    blocks = [(0, a, a + 20) for a in range(0, 120, 20)]
    found = left_out_mean_squares(regression(columns, y), blocks)
    for (_, a, b), square in zip(blocks, found, strict=True):
        others = np.r_[0:a, b:120]
        x = np.linalg.lstsq(columns[others], y[others], rcond=None)[0]
        # The formula is exact for a linear model: only rounding remains.
        assert square == pytest.approx(np.mean((columns[a:b] @ x - y[a:b]) ** 2), rel=1e-9)


def test_a_parameter_without_influence_changes_nothing():
    random = np.random.default_rng(2)
    columns, y = random.normal(size=(90, 2)), random.normal(size=90)
    blocks = [(0, a, a + 30) for a in range(0, 90, 30)]
    with_idle = TimeResiduals(
        regression(columns, y).runs, [np.c_[columns, np.zeros(90)][:, None, :]], np.ones(1), np.zeros((0, 3))
    )
    assert left_out_mean_squares(with_idle, blocks) == pytest.approx(
        left_out_mean_squares(regression(columns, y), blocks), rel=1e-9
    )


@pytest.mark.parametrize("decay", [0.0, 0.9, 0.98])
def test_blocks_are_longer_than_the_correlation(decay):
    noise = lfilter([1.0], [1.0, -decay], np.random.default_rng(3).normal(size=6000))
    time_constant = -1 / np.log(decay) if decay else 0.0
    found = correlation_length(noise)
    # An autocorrelation of exp(-lag / tau) meets the limit of significance, 0.05 for 6,000 samples, at 3 tau; estimated
    # autocorrelations fluctuate by about the limit itself.
    assert 1.5 * time_constant <= found <= max(8, 8 * time_constant)


def test_blocks_cover_every_sample_once():
    found = TimeResiduals(
        [np.random.default_rng(4).normal(size=(n, 1)) for n in (500, 37)], [], np.ones(1), np.zeros((0, 1))
    )
    blocks = partition(found)
    for run, n in enumerate((500, 37)):
        covered = np.concatenate([np.arange(a, b) for i, a, b in blocks if i == run])
        assert np.array_equal(covered, np.arange(n))
    assert mean_squares(found, blocks) @ [b - a for _, a, b in blocks] == pytest.approx(
        sum(float(np.sum(run**2)) for run in found.runs)
    )


@pytest.mark.slow
def test_sandwich_errors_are_those_of_repeated_experiments():
    # Errors correlated over 20 samples and a regressor that is as slow: the usual error is too small by a factor of
    # about 3. 400 repetitions give the scatter to 3.5 %; 30 blocks of 100 samples bias the sandwich low by some per
    # cent.
    random, values, claimed, naive = np.random.default_rng(5), [], [], []
    slow = lfilter([1.0], [1.0, -0.95], random.normal(size=3000))
    for _ in range(400):
        y = 2.0 * slow + lfilter([1.0], [1.0, -0.95], random.normal(size=3000))
        found = regression(slow[:, None], y)
        values.append(float(slow @ y / (slow @ slow)))
        claimed.append(float(sandwich_covariance(found, [(0, a, a + 100) for a in range(0, 3000, 100)])[0, 0]))
        naive.append(float(found.runs[0].var() / (slow @ slow)))
    assert np.sqrt(np.mean(claimed)) == pytest.approx(np.std(values), rel=0.15)
    assert np.sqrt(np.mean(naive)) < 0.5 * np.std(values)


def in_low_part(columns: np.ndarray, y: np.ndarray) -> tuple[TimeResiduals, TimeResiduals]:
    """A least-squares fit over all frequencies, and its residuals and derivatives in the lowest quarter of them."""
    whole, keep = regression(columns, y), len(y) // 4

    def low(values: np.ndarray) -> np.ndarray:
        coefficients = dct(values, axis=0, norm="ortho")
        coefficients[keep:] = 0.0
        return idct(coefficients, axis=0, norm="ortho")

    return whole, TimeResiduals([low(whole.runs[0])], [low(whole.slopes[0])], whole.scale, whole.priors)


def test_values_that_depend_on_the_band_are_those_of_fits_in_each_band():
    # The gain is 2 at low and 1.5 at high frequencies, which a constant gain does not represent.
    random = np.random.default_rng(7)
    x = random.normal(size=2000)
    coefficients = dct(x, norm="ortho") * np.where(np.arange(2000) < 500, 2.0, 1.5)
    y = idct(coefficients, norm="ortho") + 0.1 * random.normal(size=2000)
    whole, low = in_low_part(x[:, None], y)
    slow, target = low.slopes[0][:, 0, 0], dct(y, norm="ortho")
    target[500:] = 0.0
    of_low = float(slow @ idct(target, norm="ortho") / (slow @ slow))
    found = band_dependence(whole, low, [(0, a, a + 100) for a in range(0, 2000, 100)], 2.0)
    # A linear fit: the first-order difference is exact, and only rounding remains.
    assert found[0] == pytest.approx(of_low - float(x @ y / (x @ x)), rel=1e-9)
    assert found[0] > 0.3


def test_values_of_a_right_model_rarely_depend_on_the_band():
    random, found = np.random.default_rng(8), []
    for _ in range(300):
        columns = random.normal(size=(600, 2))
        whole, low = in_low_part(columns, columns @ [1.0, -2.0] + lfilter([1.0], [1.0, -0.5], random.normal(size=600)))
        found.append(band_dependence(whole, low, [(0, a, a + 30) for a in range(0, 600, 30)], 2.0) != 0)
    # Two standard errors are exceeded by chance in 4.6 % of draws; 20 blocks and 600 draws allow up to 9 %.
    assert np.mean(found) < 0.09


def test_a_parameter_without_influence_does_not_depend_on_the_band():
    random = np.random.default_rng(9)
    columns, y = np.c_[random.normal(size=400), np.zeros(400)], random.normal(size=400)
    found = band_dependence(*in_low_part(columns, y), [(0, a, a + 40) for a in range(0, 400, 40)], 0.0)
    assert found[1] == 0.0 and np.all(np.isfinite(found))


def test_a_single_block_gives_no_certainty():
    before, after = np.array([1.0]), np.array([0.27])
    share = closed_share(before, after, 0.0)
    assert (share.share, share.low, share.high) == pytest.approx((0.73, -1.0, 1.0))
    assert standard_error(before - after) == np.inf
    two = np.array([1.0, 3.0])
    assert standard_error(two) == pytest.approx(1.0)  # deviation sqrt(2) of n - 1, over sqrt(2)


@pytest.mark.parametrize(("blocks", "least", "count"), [([(0, 0, 100)], 8, 8), ([(0, 0, 50), (1, 0, 30), (1, 30, 60)], 8, 9), ([(0, a, a + 10) for a in range(0, 90, 10)], 8, 9)])
def test_blocks_are_divided_where_they_are_few(blocks, least, count):
    parts = divided(blocks, least)
    assert len(parts) == count >= least
    covered = [(run, sample) for run, a, b in parts for sample in range(a, b)]
    assert covered == [(run, sample) for run, a, b in blocks for sample in range(a, b)]


def test_errors_from_one_block_are_those_of_its_parts():
    """The gradient of a fit is zero over all samples: over one block the sandwich would be zero."""
    random = np.random.default_rng(5)
    columns, y = random.normal(size=(160, 2)), random.normal(size=160)
    residuals = regression(columns, y)
    assert np.abs(sandwich_covariance(residuals, [(0, 0, 160)])).max() < 1e-20
    errors = np.sqrt(np.diag(sandwich_covariance(residuals, divided([(0, 0, 160)], 8))))
    # White noise of deviation 1 on 160 samples: eight blocks know an error to a quarter.
    assert errors == pytest.approx(np.full(2, 1 / np.sqrt(160)), rel=0.75)
