"""The population of the published riders against the last row of the paper's table, and of samples drawn from a known one."""

import numpy as np
import pytest

from fmus.support.errors import InputError
from motofmi.identification.population import Population, population
from motofmi.workflows.measured_rider import VALUES, table_spread
from rider_fmu import riders
from rider_fmu.rigs.handlebar import HANDLEBAR_INERTIA

# Cossalter, Doria, Lot, Massaro, Meccanica 46 (2011), Table 2, last row: sigma / mu of the ten riders.
PRINTED = [0.3220, 0.2417, 0.3790, 0.3568, 0.5505, 0.4457]


def ten():
    riders_of_2011 = [riders.load(f"{number}_2011") for number in range(1, 11)]
    return population(riders_of_2011, VALUES, {"added_steer_inertia": HANDLEBAR_INERTIA})


def test_spread_is_the_printed_one():
    found = ten()
    # printed to four digits, from parameters printed to three to five: half of the last digit, and 0.1 % for the
    # rounding of the parameters
    np.testing.assert_allclose(found.standard_deviation / found.mean, PRINTED, atol=5e-5, rtol=1e-3)
    assert found.units == ("kg.m2", "kg.m2", "N.m/rad", "N.m/rad", "N.m.s/rad", "N.m.s/rad")


def test_means_and_covariances_are_those_of_the_value_files():
    found = ten()
    stiffness = [riders.contents(f"{number}_2011")["parameters"]["arm_stiffness"]["value"] for number in range(1, 11)]
    damping = [riders.contents(f"{number}_2011")["parameters"]["arm_damping"]["value"] for number in range(1, 11)]
    assert (
        found.mean[2] == pytest.approx(np.mean(stiffness)) == pytest.approx(1239.74)
    )  # the sum of the ten printed values is 12397.4
    assert found.covariance[2, 4] == pytest.approx(np.cov(stiffness, damping)[0, 1])
    assert found.correlation[2, 4] == pytest.approx(np.corrcoef(stiffness, damping)[0, 1])


def test_a_steer_inertia_that_is_zero_needs_an_offset():
    bare = population([riders.load(f"{number}_2011") for number in range(1, 11)])
    assert set(bare.names) == set(VALUES)  # what all riders share is left out
    np.testing.assert_allclose(
        bare.standard_deviation[bare.names.index("added_steer_inertia")], ten().standard_deviation[0]
    )
    with pytest.raises(InputError, match="added_steer_inertia is not positive in every component"):
        bare.draws(1)


def test_draws_have_the_moments_of_the_population():
    found = ten()
    drawn = table_spread(200_000, seed=1)
    assert np.all(drawn > 0)
    # the mean of 200,000 scatters by 0.1 %, their standard deviation by 1 % for these skew distributions
    np.testing.assert_allclose(drawn.mean(axis=0), found.mean, rtol=0.005)
    np.testing.assert_allclose(drawn.std(axis=0), found.standard_deviation, rtol=0.03)


def test_a_known_log_normal_population_is_found_again():
    rng = np.random.default_rng(0)
    mean, covariance = np.array([0.5, -1.0]), np.array([[0.04, 0.018], [0.018, 0.09]])
    found = Population(("a", "b"), ("1", "1"), np.exp(rng.multivariate_normal(mean, covariance, 100_000)))
    m, c = found.logarithmic
    np.testing.assert_allclose(m, mean, atol=0.005)
    np.testing.assert_allclose(c, covariance, atol=0.002)


def test_wrong_questions():
    one, other = riders.load("1_2011"), riders.load("roll_1_2008")
    with pytest.raises(InputError, match="two or more components of one kind, not 1"):
        population([one])
    with pytest.raises(InputError, match="of one kind, not 2"):
        population([one, other])
    with pytest.raises(
        InputError, match="unknown parameter of PassiveRider 'arm_stifness', did you mean 'arm_stiffness'"
    ):
        population([one, one], ["arm_stifness"])
    with pytest.raises(InputError, match="the same in every parameter"):
        population([one, one])


def test_shown_in_a_notebook():
    page = ten()._repr_html_()
    assert "<table>" in page and "data:image/png" in page and repr(ten()).startswith("Population(10 components")
    assert list(ten().to_dataframe().columns) == ["mean", "standard_deviation", "unit"]
