"""The page on the API by example: its blocks run, in order, and give what the page says."""

import re

import matplotlib
import matplotlib.pyplot as plt
import numpy as np
import pytest
from scipy.io import loadmat

from fmus.export.compilers import host_compiler
from motofmi.frequency_response.excitation import sweep
from motofmi.recordings.reading import write_recording
from motofmi.virtual_rig.simulated_rig import steer_test
from rider_fmu import riders
from tests import ROOT
from tests.simulators.hidden_joint import joint_run

matplotlib.use("Agg")
PAGE = ROOT / "docs" / "python.md"
FRICTION = 0.3  # N.m
BLOCKS = [
    found.group(1) for found in re.finditer(r"^```python\n(.*?)^```", PAGE.read_text("utf-8"), re.MULTILINE | re.DOTALL)
]
pytestmark = pytest.mark.skipif(host_compiler() is None, reason="no C compiler on this machine")


def left_by_the_blocks(folder):
    """The names that the page's blocks leave behind, run in a folder with the recordings that the page reads."""
    left = {}
    with pytest.MonkeyPatch.context() as patched:
        patched.chdir(folder)
        for k in (1, 2):
            write_recording(
                steer_test(riders.load("1_2011"), 0.125, sweep(duration=60), seed=k, oversampling=2), f"sweep_{k}.csv"
            )
            write_recording(
                joint_run({"friction": FRICTION}, "multisine", seed=8 + k, duration=5.0, name=f"joint_{k}"),
                f"joint_{k}.csv",
            )
        for block in BLOCKS:
            exec(compile(block, str(PAGE), "exec"), left)
    plt.close("all")
    return {**left, "folder": folder}


def the_modes_are_named(names):
    modes = names["modes"]
    assert (
        set(modes.unstable) >= {"weave", "wobble", "capsize"}
        and len(modes["wobble"].frequency) == len(modes.speed) == 118
    )
    assert names["both"]["alone"]["weave"].damping_ratio[0] != names["both"]["damper"]["weave"].damping_ratio[0]


def the_files_are_written(names):
    assert {"bike.mat", "run.csv", "fit.html", "mine.toml", "gap", "out"} <= {
        path.name for path in names["folder"].iterdir()
    }
    rows = np.loadtxt(names["folder"] / "run.csv", delimiter=",", skiprows=1)
    np.testing.assert_array_equal(rows, names["run"].rows)


def matlab_reads_the_matrices_with_their_names(names):
    found, space = loadmat(names["folder"] / "bike.mat", simplify_cells=True), names["space"]
    for matrix in "ABCD":
        np.testing.assert_array_equal(found[matrix], getattr(space, matrix))
    assert (
        tuple(found["states"]) == space.states
        and tuple(found["inputs"]) == space.inputs
        and tuple(found["outputs"]) == space.outputs
    )


def the_rider_and_the_effect_are_found(names):
    damping = names["fit"].parameters["arm_damping"]
    assert damping["value"] == pytest.approx(
        riders.load("1_2011").values["arm_damping"], abs=4 * damping["standard_error"]
    )
    gap = names["gap"]
    assert (gap.verdict, [effect["name"] for effect in gap.effects]) == ("named", ["coulomb_friction"])


def the_spring_swings_as_its_equation_says(names):
    mass, stiffness, damping = 2.0, 800.0, 4.0
    eigenvalues = np.linalg.eigvals(names["mf"].linearise(names["Spring"]()).A)
    decay = damping / (2 * mass)
    assert sorted(eigenvalues.imag) == pytest.approx(
        [-np.sqrt(stiffness / mass - decay**2), np.sqrt(stiffness / mass - decay**2)]
    )
    np.testing.assert_allclose(eigenvalues.real, -decay)


def every_result_shows_itself(names):
    for name in ("modes", "both", "response", "built", "run", "alone", "frf", "fit", "gap"):
        assert len(repr(names[name])) < 600 and " at 0x" not in repr(names[name]), name
        assert names[name]._repr_html_().startswith("<"), name
        assert names[name].to_dict() if hasattr(names[name], "to_dict") else name == "alone"


CLAIMS = (
    the_modes_are_named,
    the_files_are_written,
    matlab_reads_the_matrices_with_their_names,
    the_rider_and_the_effect_are_found,
    the_spring_swings_as_its_equation_says,
    every_result_shows_itself,
)


@pytest.mark.study
def test_the_blocks_run_in_order_and_give_what_the_page_says(tmp_path):
    """One test, so that the blocks run once, however the tests are spread over workers."""
    names = left_by_the_blocks(tmp_path)
    for holds in CLAIMS:
        holds(names)
