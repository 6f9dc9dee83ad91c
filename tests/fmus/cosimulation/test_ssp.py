"""SSP archives: against the schema, fmpy's runner, and the FMUs that went in; participation; wiring that is refused."""

import json
import re
import zipfile
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from fmpy.ssp.simulation import simulate_ssp
from fmpy.ssp.ssd import Parameter, ParameterSet, read_ssd
from lxml import etree
from scipy.io import loadmat

import motofmi as mf
from fmus.cosimulation.cosimulate import cosimulate
from fmus.cosimulation.network import Network, agree
from fmus.cosimulation.ssp import read_ssp, write_ssp
from fmus.export.build import build
from fmus.linear_analysis.linearisation import StateSpace, linearise
from fmus.linear_analysis.participation import participation
from fmus.support.errors import InputError
from motofmi.cli.main import main
from tests.coupled import MOTORCYCLE, RIDER
from vehicle_fmu import dampers, ridden

PORT = {**{f"device.{n}": [f"vehicle.{n}"] for n in ("steer_angle", "steer_rate", "frame_rate")},
        **{f"vehicle.{n}": [f"device.{n}"] for n in ("handlebar_torque", "frame_torque")}}  # fmt: skip
SCHEMAS = Path(__file__).parent / "vendor" / "ssp2"
VALUES = {"vehicle": {"speed": 30.0, "steer_rate": 0.5, "added_steer_inertia": 0.02}, "device": {"arm_damping": 25.0}}


def valid(part):
    """Whether an element is valid against a schema of SSP 2.0: those in `vendor`, with their licence. fmpy has those of
    1.0."""
    schema = etree.XMLSchema(file=str(SCHEMAS / f"SystemStructure{part}.xsd"))
    return lambda element: schema.validate(etree.fromstring(etree.tostring(element)))


@pytest.fixture
def archive(tmp_path):
    fmus = {"vehicle": build(MOTORCYCLE, tmp_path).path, "device": build(RIDER, tmp_path).path}
    return write_ssp(tmp_path / "ridden.ssp", fmus, PORT, VALUES)


def test_the_structure_is_valid_ssp_with_units_and_bindings(archive):
    structure = read_ssd(str(archive), validate=True)
    assert [c.name for c in structure.system.elements] == ["vehicle", "device"]
    text = zipfile.ZipFile(archive).read("SystemStructure.ssd").decode()
    assert '<ssc:Unit name="N.m"><ssc:BaseUnit kg="1" m="2" s="-2" />' in "".join(
        line.strip() for line in text.splitlines()
    )
    assert 'name="handlebar_torque" kind="input"' in text


def test_what_is_read_back_runs_as_what_was_written(archive):
    system = read_ssp(archive)
    subsystems, wiring = system.subsystems, system.wiring
    assert wiring == PORT
    assert system.fmus["device"].get("arm_damping") == 25.0
    exact = linearise(
        ridden(MOTORCYCLE, RIDER.with_values(arm_damping=25.0, added_steer_inertia=0.02)), **{"vehicle.speed": 30.0}
    )
    found = Network(subsystems, wiring).linearised()
    for eigenvalue in np.linalg.eigvals(exact.A):
        assert np.abs(np.linalg.eigvals(found.A) - eigenvalue).min() <= 1e-9 * abs(eigenvalue)
    assert np.abs(cosimulate(subsystems, 1e-2, 0.1, wiring=wiring)["vehicle.roll_angle"]).max() > 0
    system.close()


@pytest.mark.slow
def test_fmpy_runs_the_archive(archive):
    # fmpy reads the bindings of an archive, but its runner applies only what it is given by hand.
    bound = [
        Parameter(name=f"{unit}.{name}", value=value)
        for unit, values in VALUES.items()
        for name, value in values.items()
    ]
    theirs = simulate_ssp(
        str(archive), stop_time=0.02, step_size=1e-3, parameter_set=ParameterSet(name="bound", parameters=bound)
    )
    system = read_ssp(archive)
    subsystems, wiring = system.subsystems, system.wiring
    ours = cosimulate(subsystems, 1e-3, 0.02, "jacobi", wiring=wiring)
    # Its connections are one step late and its rows are stamped one step early: alike within what a step changes.
    assert theirs["vehicle.steer_rate"][-3] == pytest.approx(ours["vehicle.steer_rate"][-3], abs=0.05 * 0.5)
    system.close()


def test_shares_of_the_units_add_up_and_find_the_rider(archive):
    system = read_ssp(archive)
    subsystems, wiring = system.subsystems, system.wiring
    eigenvalues, shares = participation(Network(subsystems, wiring).linearised())
    assert sum(shares.values()) == pytest.approx(np.ones(len(eigenvalues)))
    frequency = eigenvalues.imag / (2 * np.pi)
    rider_wobble, weave = np.argmin(np.abs(frequency - 4.8)), np.argmin(np.abs(frequency - 3.0))
    assert shares["device"][rider_wobble] > shares["device"][weave]  # the torso is what moves in the former
    system.close()


def test_participation_of_units_that_do_not_touch():
    space = StateSpace(
        np.diag([-1.0, -2.0]), np.zeros((2, 0)), np.zeros((0, 2)), np.zeros((0, 0)), ("a.x", "b.x"), (), ()
    )
    eigenvalues, shares = participation(space)
    assert eigenvalues.real.tolist() == [-1, -2]
    assert shares["a"].tolist() == [1, 0] and shares["b"].tolist() == [0, 1]


@pytest.mark.slow
def test_wrong_wiring_is_refused_by_name(tmp_path):
    fmus = {
        "vehicle": build(MOTORCYCLE, tmp_path).path,
        "device": build(RIDER, tmp_path).path,
        "damper": build(dampers.load("low_2011"), tmp_path).path,
    }
    out = tmp_path / "wrong.ssp"
    with pytest.raises(
        InputError, match=r"vehicle.frame_rate \[rad/s\] cannot drive device.steer_angle \[rad\]: the units differ"
    ):
        write_ssp(out, fmus, {"device.steer_angle": ["vehicle.frame_rate"]})
    with pytest.raises(InputError, match=r"unknown output 'vehicle.steer', did you mean"):
        write_ssp(out, fmus, {"device.steer_angle": ["vehicle.steer"]})
    with pytest.raises(
        InputError, match=r"vehicle.handlebar_torque has 2 writers: device.handlebar_torque, damper.handlebar_torque"
    ):
        write_ssp(out, fmus, {"vehicle.handlebar_torque": ["device.handlebar_torque", "damper.handlebar_torque"]})
    with pytest.raises(InputError, match="unknown variable of device 'arm_dampin'"):
        write_ssp(out, fmus, PORT, {"device": {"arm_dampin": 1.0}})
    assert not out.exists()
    out.write_text("no archive")
    with pytest.raises(InputError, match=r"wrong\.ssp is not an SSP archive"):
        read_ssp(out)


@pytest.mark.slow
def test_modes_of_an_archive_with_the_share_of_each_fmu(archive, tmp_path):
    result = tmp_path / "modes.json"
    matrices = tmp_path / "ridden.mat"
    assert main(["modes", "--ssp", str(archive), "--speed", "30,50", "--json", str(result), "--matlab", str(matrices)]) == 0
    found = json.loads(result.read_text())
    exact = linearise(
        ridden(MOTORCYCLE, RIDER.with_values(arm_damping=25.0, added_steer_inertia=0.02)), **{"vehicle.speed": 30.0}
    )
    weave = complex(*found["modes"]["weave"]["eigenvalue"][0])
    assert np.abs(np.linalg.eigvals(exact.A) - weave).min() <= 1e-9 * abs(weave)
    ridden_fmus = loadmat(matrices)
    assert ridden_fmus["speed"].ravel() == pytest.approx([30.0, 50.0])
    # The FMUs give the entries of A with the rounding of their C code.
    assert np.abs(np.linalg.eigvals(ridden_fmus["A"][:, :, 0]) - weave).min() <= 1e-9 * abs(weave)
    for mode in found["unstable"]:
        shares = found["participation"][mode]
        assert set(shares) == {"vehicle", "device"}
        assert np.sum(list(shares.values()), axis=0) == pytest.approx([1, 1])


@pytest.fixture(scope="module")
def built(tmp_path_factory, cache):
    """An archive of the command, with a speed and a start."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("MOTOFMI_CACHE", str(cache))
        path = tmp_path_factory.mktemp("built") / "ridden.ssp"
        found = mf.build(["rider:mean_2011", "sharp_1971"], ssp=path, speed=25.0, initial={"steer_rate": 0.5}, set={"arm_damping": 20.0})
        assert found.ssp == path and found.to_dict()["ssp"] == str(path)
        again = mf.build(["rider:mean_2011", "sharp_1971"], ssp=path.parent / "again" / "ridden.ssp", speed=25.0,
                         initial={"steer_rate": 0.5}, set={"arm_damping": 20.0})  # fmt: skip
        assert path.read_bytes() == again.ssp.read_bytes()
    return path


@pytest.mark.slow
def test_a_built_archive_is_valid_and_holds_values_and_the_annotation_of_omsimulator(built):
    assert [c.name for c in read_ssd(str(built), validate=True).system.elements] == ["vehicle", "device"]
    root = ElementTree.fromstring(zipfile.ZipFile(built).read("SystemStructure.ssd"))
    annotation = next(e for e in root.iter() if e.get("type") == "org.openmodelica")
    (system,) = (e for e in root if e.tag.endswith("System"))
    assert annotation in list(system[-1])  # the schema has annotations last
    master = next(e for e in annotation.iter() if e.tag.endswith("FixedStepMaster"))
    assert master.get("description") == "oms-ma" and float(master.get("stepSize")) == 0.001
    values = {e.get("name"): float(e[0].get("value")) for e in root.iter() if e.tag.endswith("}Parameter")}
    assert values["arm_damping"] == 20.0 and values["speed"] == 25.0 and values["steer_rate"] == 0.5


@pytest.mark.slow
def test_fmpy_runs_a_built_archive_as_it_is(built):
    # Without the parameter set, which fmpy does not read from the file: the values are built into the FMUs.
    theirs = simulate_ssp(str(built), stop_time=0.02, step_size=1e-3)
    ours = mf.cosimulate(ssp=built, duration=0.02, coupling="jacobi")
    assert ours["vehicle.steer_rate"][0] == 0.5
    assert theirs["vehicle.steer_rate"][-3] == pytest.approx(ours["vehicle.steer_rate"][-3], abs=0.05 * 0.5)  # as above


@pytest.mark.slow
def test_a_built_archive_has_the_modes_of_the_components(built):
    rider = mf.rider("mean_2011", arm_damping=20.0)
    exact = mf.modes("sharp_1971", rider, speed=[20.0, 40.0])
    found = mf.modes(ssp=built, speed=[20.0, 40.0])
    changed = mf.modes(ssp=built, speed=[20.0, 40.0], set={"device.arm_damping": 5.0})
    for mode in ("weave", "wobble"):  # rounding of the C code
        assert found[mode].eigenvalue == pytest.approx(exact[mode].eigenvalue, rel=1e-9)
        assert np.abs(changed[mode].eigenvalue - exact[mode].eigenvalue).min() > 1e-3
    run = mf.cosimulate(ssp=built, duration=0.1)
    assert set(run.errors) == {"weave", "wobble", "rider_wobble"} and run.vehicle == "ridden.ssp"


@pytest.mark.study
def test_version_2_holds_fmi_3_and_version_1_does_not(tmp_path):
    path = mf.build(["sharp_1971", "damper:7.5"], ssp=tmp_path / "two.ssp", ssp_version=2, fmi=3).ssp
    text = zipfile.ZipFile(path).read("SystemStructure.ssd").decode()
    assert 'version="2.0"' in text and '<ssc:Float64 unit="N.m" />' in text
    structure = etree.fromstring(text.encode())
    sets = structure.findall(".//{http://ssp-standard.org/SSP1/SystemStructureParameterValues}ParameterSet")
    assert len(sets) == 2 and all(map(valid("ParameterValues"), sets)) and valid("Description")(structure)
    structure[0].set("nme", "an attribute that the schema does not have")
    assert not valid("Description")(structure)
    with read_ssp(path) as system:
        assert system.fmus["device"].get("damping") == 7.5 and system.fmus["vehicle"].description.fmiVersion == "3.0"
    with pytest.raises(InputError, match=r"vehicle is an FMU of FMI 3\.0, which SSP 1\.0 does not have"):
        mf.build(["sharp_1971", "damper:7.5"], ssp=tmp_path / "one.ssp", fmi=3)
    assert not (tmp_path / "one.ssp").exists()


@pytest.mark.slow
@pytest.mark.parametrize(("names", "reason"), [
    (["damper:7.5"], "an .ssp holds one vehicle and the devices at its ports, but no vehicle is given"),
    (["sharp_1971", "reference_2011"], "but 2 vehicles are given"),
    (["sharp_1971", "rider:mean_2011", "damper:7.5"], r"vehicle\.handlebar_torque has 2 writers: .*an SSP has no sums"),
])  # fmt: skip
def test_what_is_no_system_of_one_vehicle_is_refused(tmp_path, names, reason):
    with pytest.raises(InputError, match=reason):
        mf.build(names, ssp=tmp_path / "wrong.ssp")
    assert not (tmp_path / "wrong.ssp").exists()


@pytest.mark.slow
def test_an_export_in_the_form_of_omsimulator_has_equal_parameters(built, tmp_path):
    # OMSimulator writes values of all components into one file at the root, with hierarchical names.
    with zipfile.ZipFile(built) as archive:
        structure = archive.read("SystemStructure.ssd").decode()
        fmus = {name: archive.read(name) for name in archive.namelist() if name.endswith(".fmu")}
    bindings = re.compile(r"<ssd:ParameterBindings>.*?</ssd:ParameterBindings>", re.DOTALL)
    structure = bindings.sub("", structure).replace(
        "<ssd:Elements>", '<ssd:ParameterBindings><ssd:ParameterBinding source="resources/ridden.ssv"/></ssd:ParameterBindings><ssd:Elements>'
    ).replace('version="1.0" name="ridden"', 'version="2.0" name="ridden"')  # fmt: skip
    values = {"vehicle.speed": 33.0, "device.arm_damping": 11.0, "device.torso_angle": 0.1}
    rows = "".join(f'<ssv:Parameter name="{n}"><ssv:Real value="{x}"/></ssv:Parameter>' for n, x in values.items())
    space = 'xmlns:ssv="http://ssp-standard.org/SSP1/SystemStructureParameterValues"'
    path = tmp_path / "exported.ssp"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("SystemStructure.ssd", structure)
        archive.writestr("resources/ridden.ssv", f'<ssv:ParameterSet {space} version="2.0" name="parameters"><ssv:Parameters>{rows}</ssv:Parameters></ssv:ParameterSet>')
        for name, data in fmus.items():
            archive.writestr(name, data)
    with read_ssp(path) as system:
        assert {n: system.fmus[n.partition(".")[0]].get(n.partition(".")[2]) for n in values} == values


def test_units_of_the_same_measure_agree():
    assert agree("N.m", "Nm") and agree("", "rad") and agree("bogus", "bogus")
    assert not agree("rad", "deg") and not agree("rad", "rad/s") and not agree("bogus", "rad")
