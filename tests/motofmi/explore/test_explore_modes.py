"""The numbers and names of the explore page against those of Python."""

import numpy as np
import pytest

import motofmi as mf
from tests.explore_page import (
    FLEXIBLE,
    MODES_IN_THE_PAGE,
    RIGID,
    SPEEDS,
    Opened,
    complex_numbers,
    differing_modes,
    eigenvalue_error,
    in_browser,
    modes_in_python,
    random_settings,
)


@in_browser
@pytest.mark.parametrize("vehicles", [RIGID, pytest.param(FLEXIBLE, marks=pytest.mark.study)])
def test_eigenvalues_and_names_are_those_of_python(page, vehicles):
    cases = list(random_settings(page.window.evaluate("page.data"), 2, 12, vehicles))
    for case, found in zip(cases, page.window.evaluate(MODES_IN_THE_PAGE, cases), strict=True):
        expected = modes_in_python(case)
        # two QR methods: 1e-9 of the largest eigenvalue is far above their rounding errors
        assert eigenvalue_error(found, expected) < 1e-9
        assert differing_modes(found, expected) == []
        for mode in found["curves"]:
            assert np.ravel(found["unstable"][mode]) == pytest.approx(np.ravel(expected.unstable[mode]), abs=2e-2)


RIDERS = {"full_mean_2011": "rider:full_mean_2011", "roll_1971": "rider:roll_1971",
          "mean_2011,roll_1971": ["rider:mean_2011", "rider:roll_1971"],
          "mean_2011,damper_low_2011": ["rider:mean_2011", "damper:low_2011"]}  # fmt: skip


@in_browser
@pytest.mark.parametrize("device", [pytest.param(n, marks=pytest.mark.study) if "full" in n else n for n in RIDERS])
def test_riders_who_lean_move_their_arms_or_have_a_damper_are_those_of_python(page, device):
    case = {"vehicle": "sharp_1971", "device": device, "changes": {"vehicle.trail": 0.1}}
    (found,) = page.window.evaluate(MODES_IN_THE_PAGE, [case])
    expected = mf.modes("sharp_1971", RIDERS[device], SPEEDS, set={"trail": 0.1})
    assert eigenvalue_error(found, expected) < 1e-9 and differing_modes(found, expected) == []


@in_browser
def test_an_fmu_is_a_device_without_sliders(browser, tmp_path):
    fmu = mf.build(mf.rider("2_2011"), tmp_path).path
    opened = Opened(browser, mf.explore(device=fmu, out=tmp_path / "page.html").path)
    (found,) = opened.window.evaluate(
        MODES_IN_THE_PAGE, [{"vehicle": "reference_2011", "device": "2_2011.fmu", "changes": {}}]
    )
    expected = mf.modes("reference_2011", "rider:2_2011", SPEEDS)  # the FMU's Jacobian is the exact one
    assert eigenvalue_error(found, expected) < 1e-9 and differing_modes(found, expected) == []
    assert "2_2011.fmu is an FMU of another tool" in opened.window.text_content("#parameters")
    assert "cannot step" in opened.window.text_content("#live-text") and opened.window.is_disabled("#run")
    assert opened.complaints == []
    opened.window.close()


@in_browser
def test_eigenvalues_of_matrices_with_known_ones(page):
    """Block-diagonal matrices of chosen eigenvalues in random orthogonal coordinates."""
    rng, cases, expected = np.random.default_rng(4), [], []
    for n in range(2, 12):
        reals, pairs = rng.normal(size=n % 3), rng.normal(size=((n - n % 3) // 2, 2))
        values = [*reals, *(complex(a, s * b) for a, b in pairs for s in (1, -1))]
        block = np.zeros((len(values),) * 2)
        block[range(len(reals)), range(len(reals))] = reals
        for k, (a, b) in enumerate(pairs):
            i = len(reals) + 2 * k
            block[i : i + 2, i : i + 2] = [[a, b], [-b, a]]
        Q, _ = np.linalg.qr(rng.normal(size=block.shape))
        cases.append((Q @ block @ Q.T).tolist())
        expected.append(values)
    found = page.window.evaluate(
        "cases => cases.map(A => { const {re, im} = eigenvalues(Float64Array.from(A.flat()), A.length); return [[...re], [...im]]; })",
        cases,
    )
    for parts, values in zip(found, expected, strict=True):
        assert np.sort_complex(complex_numbers(*parts)) == pytest.approx(np.sort_complex(values), abs=1e-12)


@in_browser
def test_unstable_speeds_and_the_reading_are_those_of_the_modes(page):
    expected = mf.modes("sharp_1971", "rider:mean_2011", SPEEDS)
    ((low, high),) = expected.unstable["weave"]
    row = page.window.locator("#readings table").nth(1).locator("tr", has_text="weave").first.text_content()
    assert f"{low:.1f} to {high:.1f}" in row and f"{expected['weave'].frequency[29]:.2f}" in row
