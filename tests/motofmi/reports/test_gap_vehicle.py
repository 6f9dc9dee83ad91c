"""The figure of eigenvalues over speed: curves are at the speeds of their axis, differences in standard errors."""

from types import SimpleNamespace

import numpy as np
import pytest

from fmus import linearise
from motofmi.gap.preprocessing.eigenvalues import MeasuredEigenvalues
from motofmi.reports.gap_vehicle import branches, eigenvalues_over_speed
from vehicle_fmu import motorcycles

SPEEDS = np.linspace(8, 56, 13)


class Shifted:
    """A motorcycle as the model of a fit; its predicted parts are those measured plus some standard errors."""

    def __init__(self, bike, errors, effects=()):
        self.bike, self.errors, self.effects = bike, errors, effects

    def linearised(self, shared, speeds):
        return linearise(self.bike, speed=speeds), None

    def reduced(self, run, shared):
        return run.data / run.deviation + self.errors, None


@pytest.fixture(scope="module")
def drawn():
    bike = motorcycles.load("sharp_1971")
    weave = np.array([-5.2 + 15j, -1.5 + 18j, -1.0 + 21j])
    run = MeasuredEigenvalues("a", np.array([20.0, 35.0, 50.0]), ("weave",) * 3, weave, np.full(3, 0.1), np.full(3, 0.2))
    base, best = (SimpleNamespace(model=Shifted(bike, e, x), shared=None, runs=[run]) for e, x in ((3.0, ()), (0.5, ("an effect",))))
    return bike, run, base, eigenvalues_over_speed(SimpleNamespace(base=base, best=best, verdict="named"))


@pytest.mark.slow
def test_branches_are_at_the_speeds_although_the_tracking_adds_some(drawn):
    bike, _, fit, _ = drawn
    found = branches(fit, SPEEDS)
    expected = np.linalg.eigvals(linearise(bike, speed=SPEEDS).A)
    assert np.sort_complex(found) == pytest.approx(np.sort_complex(expected), rel=1e-9)


@pytest.mark.slow
def test_measured_values_and_differences_are_drawn_beside_the_models(drawn):
    bike, run, _, chart = drawn
    real, frequency, *differences = chart.panels
    (measured,) = [c for c in real.curves if c.name == "measured"]
    np.testing.assert_allclose(measured.y, run.value.real)
    (measured,) = [c for c in frequency.curves if c.name == "measured"]
    np.testing.assert_allclose(measured.y, run.value.imag / 2 / np.pi)
    for curve in (c for c in real.curves if c.name == "base"):
        for speed, part in list(zip(curve.x, curve.y, strict=True))[::33]:
            spectrum = np.linalg.eigvals(linearise(bike, speed=speed).A).real
            assert np.isnan(part) or np.abs(spectrum - part).min() < 1e-9
    for panel in differences:
        assert [(c.name, np.round(c.y, 9).tolist()) for c in panel.curves] == [
            ("base", [3.0] * 3), ("with the effects found", [0.5] * 3)]  # fmt: skip
