"""Every platform from one machine: the right file formats, old C libraries, the same bytes again, the same numbers."""

import re
import shutil
import struct
import subprocess
import zipfile
from importlib.util import find_spec
from pathlib import Path

import fmpy
import numpy as np
import pytest

from fmus.export.build import build, build_all
from fmus.export.compilers import PLATFORMS, host, universal, zig
from fmus.support.errors import InputError
from rider_fmu import riders
from tests import ROOT
from tests.importer import COMPONENTS, Opened

HOST_PROGRAM = ROOT / "tests" / "c" / "run_fmu.c"
needs_zig = pytest.mark.skipif(
    find_spec("ziglang") is None, reason="ziglang is not installed (pip install motofmi[platforms])"
)


@pytest.fixture(scope="module")
def archives(tmp_path_factory):
    """The rider for all platforms that compile in seconds; Windows takes a minute the first time and is built where it
    can run."""
    folder, cache = tmp_path_factory.mktemp("out"), tmp_path_factory.mktemp("cache")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("MOTOFMI_CACHE", str(cache))
        return {
            fmi: build_all(COMPONENTS["rider"](), folder, fmi=fmi, platforms="linux-x86_64,linux-arm64,macos")
            for fmi in (2, 3)
        }


def libraries(built):
    with zipfile.ZipFile(built.path) as archive:
        return {n.split("/")[1]: archive.read(n) for n in archive.namelist() if n.startswith("binaries/")}


@pytest.mark.slow
@needs_zig
def test_archives_and_their_names(archives):
    assert [b.path.name for b in archives[2]] == ["rider_mean_2011.fmu", "rider_mean_2011_arm64.fmu"]
    assert [b.path.name for b in archives[3]] == ["rider_mean_2011_fmi3.fmu"]
    assert set(libraries(archives[2][0])) == {"linux64", "darwin64"} and set(libraries(archives[2][1])) == {"linux64"}
    assert set(libraries(archives[3][0])) == {"x86_64-linux", "aarch64-linux", "x86_64-darwin", "aarch64-darwin"}
    for built in [*archives[2], *archives[3]]:
        assert built.path.stat().st_size < 300_000


@pytest.mark.study
@needs_zig
@pytest.mark.parametrize("fmi", [2, 3])
def test_the_largest_component_for_all_platforms_is_no_large_archive(fmi, tmp_path):
    for built in build_all(riders.load("full_mean_2011"), tmp_path, fmi=fmi, platforms="all"):
        assert built.path.stat().st_size < 400_000


@pytest.mark.slow
@needs_zig
def test_linux_libraries_need_no_newer_c_library_than_2_17(archives):
    machines = {"linux64": 62, "x86_64-linux": 62, "aarch64-linux": 183}  # ELF's e_machine: x86-64, AArch64
    for built in [archives[2][0], archives[3][0]]:
        for folder, data in libraries(built).items():
            if "linux" in folder:
                assert data[:4] == b"\x7fELF" and struct.unpack("<H", data[18:20])[0] == machines[folder]
                versions = [tuple(map(int, v.split(b"."))) for v in re.findall(rb"GLIBC_(\d+\.\d+)", data)]
                assert max(versions) <= (2, 17)
                assert b"Py_" not in data and b"PyObject" not in data


@pytest.mark.slow
@needs_zig
def test_the_library_for_macos_is_universal(archives):
    data = libraries(archives[2][0])["darwin64"]
    magic, count = struct.unpack(">II", data[:8])
    slices = [struct.unpack(">5I", data[8 + 20 * i : 28 + 20 * i]) for i in range(count)]
    assert magic == 0xCAFEBABE and [s[0] for s in slices] == [0x01000007, 0x0100000C]  # x86-64, ARM64
    for cpu, _, offset, size, align in slices:
        assert data[offset : offset + 8] == struct.pack("<II", 0xFEEDFACF, cpu) and offset % (1 << align) == 0
        assert offset + size <= len(data)


@pytest.mark.slow
def test_universal_keeps_every_slice():
    thin = [struct.pack("<III", 0xFEEDFACF, 7, 3) + bytes([i]) * 100 for i in range(3)]
    data = universal(thin)
    for i in range(3):
        _, _, offset, size, _ = struct.unpack(">5I", data[8 + 20 * i : 28 + 20 * i])
        assert data[offset : offset + size] == thin[i]


@pytest.mark.slow
@needs_zig
def test_a_second_build_has_the_same_bytes(archives, tmp_path, monkeypatch):
    monkeypatch.setenv("MOTOFMI_CACHE", str(tmp_path / "empty"))
    again = build_all(COMPONENTS["rider"](), tmp_path, fmi=3, platforms="linux-x86_64,linux-arm64,macos")
    assert again[0].path.read_bytes() == archives[3][0].path.read_bytes()


@pytest.mark.slow
@needs_zig
@pytest.mark.skipif(host().name != "linux-x86_64", reason="the library is one for Linux on x86-64")
def test_zig_and_the_host_s_compiler_give_the_same_trajectory(archives, opened):
    component = COMPONENTS["rider"]()
    one, other = Opened(archives[2][0].path).start(torso_angle=0.1), opened(component).start(torso_angle=0.1)
    times = np.linspace(0, 1, 101)
    rows = [fmu.run(times, lambda t: {"steer_rate": np.sin(9 * t)}, component.outputs) for fmu in (one, other)]
    one.close()
    assert rows[0] == pytest.approx(rows[1], rel=1e-13, abs=1e-13)  # the order of a sum is all that may differ


def outputs_by_host_program(command, target, library, description, tmp_path, suffix=""):
    """What the host program, compiled for a target, prints with a library of that target."""
    program = f"run_fmu{suffix}"
    headers = Path(fmpy.__file__).parent / "c-code"
    link = [] if "windows" in target else ["-ldl"]
    subprocess.run(
        [*zig(), "-target", target, "-I", str(headers), str(HOST_PROGRAM), "-o", program, *link],
        cwd=tmp_path,
        check=True,
    )
    kinds = {
        k: [str(v.valueReference) for v in description.modelVariables if v.causality == k] for k in ("input", "output")
    }
    arguments = [f"./{library}", description.guid, "50", *kinds["input"], "--", *kinds["output"]]
    done = subprocess.run(
        [*command, f"./{program}", *arguments], cwd=tmp_path, capture_output=True, text=True, check=True
    )
    return np.array([float(x) for x in done.stdout.split()])


def expected_outputs(description, component, opened):
    fmu = opened(component).start()
    inputs = [v.name for v in description.modelVariables if v.causality == "input"]
    for step in range(50):
        fmu.set(**{n: 1 + ((step * 7 + i * 3) % 11) / 16 for i, n in enumerate(inputs)})
        fmu.fmu.doStep(step / 128, 1 / 128)
    return fmu.get(*(v.name for v in description.modelVariables if v.causality == "output"))


@pytest.mark.slow
@needs_zig
@pytest.mark.parametrize(
    ("platform", "runner", "suffix"),
    [("linux-x86_64", None, ""), ("windows-x86_64", "wine", ".exe"), ("linux-arm64", "qemu-aarch64", "")],
)
def test_libraries_of_other_platforms_give_the_same_numbers(platform, runner, suffix, opened, tmp_path):
    command = []
    if runner is None and host().name != platform:
        pytest.skip(f"this machine is no {platform}")
    if runner is not None:
        if shutil.which(runner) is None:
            pytest.skip(f"{runner} is not installed")
        command = [runner]
        if runner == "qemu-aarch64":
            if not Path("/usr/aarch64-linux-gnu/lib").is_dir():
                pytest.skip("no C library for ARM64 in /usr/aarch64-linux-gnu")
            command += ["-L", "/usr/aarch64-linux-gnu"]
    component = COMPONENTS["motorcycle"]()
    built = build(component, tmp_path, platforms=platform)
    description = fmpy.read_model_description(built.path)
    library = f"{built.name}{PLATFORMS[platform].suffix}"
    (tmp_path / library).write_bytes(libraries(built)[PLATFORMS[platform].folder])
    found = outputs_by_host_program(command, PLATFORMS[platform].targets[0], library, description, tmp_path, suffix)
    # Other sine and cosine functions in other C libraries: last digits, grown over 50 steps of a light motorcycle.
    assert found == pytest.approx(expected_outputs(description, component, opened), rel=1e-11)


@pytest.mark.slow
def test_two_kinds_of_linux_in_one_fmi_2_archive_are_refused(tmp_path):
    with pytest.raises(InputError, match="share one folder"):
        build(COMPONENTS["rider"](), tmp_path, platforms="all")
