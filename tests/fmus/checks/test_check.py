"""`check` finds every fault that was put in on purpose, and none in what we build."""

import os
import re
import shutil
import struct
import subprocess
import sys
import time
import zipfile

import pytest

from fmus.checks.check import Limits
from fmus.checks.check import check as every_check
from fmus.export.build import archive, binaries, build, source_contents
from fmus.export.compilers import host, host_compiler
from fmus.export.interface import Interface
from fmus.support.errors import InputError
from fmus.support.untrusted_archive import LARGEST_MEMBER
from rider_fmu import riders
from tests import ROOT, as_study
from tests.importer import COMPONENTS

pytestmark = pytest.mark.skipif(host_compiler() is None, reason="no C compiler on this machine")


@pytest.fixture(scope="module")
def sound(cache, tmp_path_factory):
    """The files of a sound archive."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("MOTOFMI_CACHE", str(cache))
        path = build(riders.load("mean_2011"), tmp_path_factory.mktemp("out")).path
    with zipfile.ZipFile(path) as members:
        return {name: members.read(name) for name in members.namelist()}


def check(path, time_limit=20.0):
    """Without the opinions of other tools, which take seconds."""
    return every_check(path, Limits(time=time_limit), other_tools=False)


def written(tmp_path, contents):
    path = tmp_path / "broken.fmu"
    path.write_bytes(archive(contents))
    return path


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "fmi"),
    [("rider", 2), ("oscillator", 3), *map(as_study, ("motorcycle", "progressive", "system", "oscillator"), (3, 2, 3, 2))],
)
def test_ours_are_clean(name, fmi, tmp_path):
    assert check(build(COMPONENTS[name](), tmp_path, fmi=fmi).path) == []


@pytest.mark.study
@pytest.mark.parametrize("name", ["rider", as_study("progressive")])
def test_the_limits_of_the_python_back_end_are_warnings(name, tmp_path):
    found = check(build(COMPONENTS[name](), tmp_path, backend="python").path)
    assert {p.severity for p in found} == {"warning"}
    assert "python" in {p.check for p in found} <= {"python", "wrong_token", "unknown_reference", "input_not_a_number", "input_above_maximum", "fixed_parameter",
                                                    "negative_step", "step_not_a_number", "step_too_early"}  # fmt: skip


LAST_UNKNOWN = b'      <Unknown index="19" dependencies="2 3 4 5 6 7 10 11 12 13 14" />\n'
BROKEN = {
    "wrong identifier": (b'modelIdentifier="rider_mean_2011"', b'modelIdentifier="somebody_else"', "identifier", "no library for modelIdentifier 'somebody_else'"),
    "missing initial unknown": (LAST_UNKNOWN, b"", "structure", "InitialUnknowns does not list der(torso_momentum)"),
    "undefined unit": (b'<Real unit="N.m" />', b'<Real unit="furlong" />', "units", "unit [furlong] is not defined"),
    "duplicate name": (b'name="waist_damping"', b'name="arm_damping"', "names", "the name 'arm_damping' is not unique"),
    "dependency out of range": (b'dependencies="11 12 13 14"', b'dependencies="11 12 13 99"', "structure", "99 is no variable (valid: 1 to 19)"),
    "wrong output index": (b'<Unknown index="16" dependencies="11', b'<Unknown index="5" dependencies="11', "structure", "Outputs does not list"),
    "input without start": (b'<Real unit="rad" displayUnit="deg" start="0.0" />\n    </ScalarVariable>\n    <ScalarVariable name="steer_rate"',
                            b'<Real unit="rad" displayUnit="deg" />\n    </ScalarVariable>\n    <ScalarVariable name="steer_rate"', "attributes", "has no start value"),
    "min above start": (b'min="0.0" max="100000.0" displayUnit="N.m.s/deg" start="19.28"', b'min="20.0" max="100000.0" displayUnit="N.m.s/deg" start="19.28"',
                        "bounds", "min 20 is above start 19.28"),
    "bad date": (b"00:00:00Z", b"00:00:00+00:00", "date", "is not of the form"),
}  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("fault", BROKEN)
def test_a_broken_model_description_is_caught(fault, sound, tmp_path):
    good, bad, name, message = BROKEN[fault]
    assert good in sound["modelDescription.xml"]
    # Only the identifier is compared with the binary; without one the description is checked, and no trial is made.
    contents = {n: d for n, d in sound.items() if name == "identifier" or not n.startswith("binaries/")}
    found = check(written(tmp_path, {**contents, "modelDescription.xml": contents["modelDescription.xml"].replace(good, bad)}))
    severity = "warning" if name == "date" else "error"
    assert [p for p in found if p.check == name and p.severity == severity and message in p.message], found


@pytest.mark.slow
def test_no_binary_is_caught(sound, tmp_path):
    found = check(written(tmp_path, {n: d for n, d in sound.items() if not n.startswith(("binaries/", "sources/"))}))
    assert ("binary", "error") in [(p.check, p.severity) for p in found] and "no binary for any platform" in found[
        0
    ].message + found[-1].message


def changed_code(old, new, tmp_path):
    """The rider with other C code in model.c, compiled."""
    interface = Interface(riders.load("mean_2011"))
    contents = source_contents(interface, 2)
    assert old in contents["sources/model.c"]
    contents["sources/model.c"] = contents["sources/model.c"].replace(old, new)
    return written(tmp_path, {**contents, **binaries(interface.identifier, contents, 2, [host()], native=True)})


@pytest.mark.slow
@pytest.mark.skipif(os.name == "nt", reason="signals")
def test_a_crash_is_survived_and_reported(tmp_path):
    found = check(changed_code(b"    (void)z, (void)f;\n", b"    (void)z, (void)f; __builtin_trap();\n", tmp_path))
    assert [p for p in found if "crashed with signal" in p.message]


@pytest.mark.slow
def test_an_endless_loop_is_survived_and_reported(tmp_path):
    found = check(
        changed_code(
            b"(void)sign, (void)heaviside;\n",
            b"(void)sign, (void)heaviside; for (volatile int i = 0; i < 1; ) ;\n",
            tmp_path,
        ),
        time_limit=2,
    )
    assert [p for p in found if "did not finish within 2 s" in p.message and p.call]


@pytest.mark.slow
def test_a_wrong_jacobian_is_found(tmp_path):
    found = check(changed_code(b"    j[8] = v_arm_stiffness;\n", b"    j[8] = 1.01*v_arm_stiffness;\n", tmp_path))
    assert [p for p in found if p.check == "derivatives" and "d der(torso_momentum) / d steer_angle" in p.message]


@pytest.mark.slow
def test_numbers_that_do_not_repeat_are_found(tmp_path):
    found = check(changed_code(b"    z[15] = ", b"    static int calls; z[15] = 1e-9 * calls++ + ", tmp_path))
    assert {"reset", "state"} <= {p.check for p in found}


def test_a_file_that_is_no_archive_and_one_that_is_not_there(tmp_path):
    path = tmp_path / "text.fmu"
    path.write_text("no archive")
    (found,) = check(path)
    assert (found.check, found.severity) == ("archive", "error")
    with pytest.raises(InputError, match="no such file"):
        check(tmp_path / "missing.fmu")


def with_member(sound, tmp_path, name, data=b"x", attributes=0):
    path = written(tmp_path, sound)
    with zipfile.ZipFile(path, "a", zipfile.ZIP_DEFLATED) as members:
        entry = zipfile.ZipInfo(name)
        entry.external_attr, entry.compress_type = attributes, zipfile.ZIP_DEFLATED
        members.writestr(entry, data)
    return path


@pytest.mark.slow
@pytest.mark.parametrize(
    "name", ["../outside.txt", "/tmp/outside.txt", "resources/../../outside.txt", "..\\outside.txt", "C:/outside.txt"]
)
def test_a_path_out_of_the_folder_is_refused_before_unpacking(name, sound, tmp_path):
    found = check(with_member(sound, tmp_path, name))
    assert [p.message for p in found] == ["the path leaves the folder of the archive"]
    assert not (tmp_path.parent / "outside.txt").exists()


@pytest.mark.slow
def test_a_link_is_refused_before_unpacking(sound, tmp_path):
    (found,) = check(with_member(sound, tmp_path, "resources/link", b"/etc/passwd", 0o120777 << 16))
    assert found.message == "is a symbolic link"


@pytest.mark.slow
def test_an_oversized_member_is_refused_before_unpacking(sound, tmp_path):
    path = with_member(sound, tmp_path, "resources/zeros", bytes(2**24))
    (found,) = check(path)
    assert "times its size" in found.message
    data = bytearray(path.read_bytes())
    place = data.rfind(b"resources/zeros") - 46  # the entry in the central directory; its size is 24 bytes in
    struct.pack_into("<I", data, place + 24, LARGEST_MEMBER + 1)
    path.write_bytes(data)
    assert "more than" in check(path)[0].message


@pytest.mark.slow
@pytest.mark.parametrize("encoding", ["utf-8", "utf-16"])
def test_external_entities_are_refused_before_unpacking(encoding, sound, tmp_path):
    text = (
        f'<?xml version="1.0" encoding="{encoding}"?><!DOCTYPE a [<!ENTITY b SYSTEM "file:///etc/passwd">]><a>&b;</a>'
    )
    (found,) = check(with_member(sound, tmp_path, "extra/other.xml", text.encode(encoding)))
    assert "declares a document type" in found.message


def test_entities_in_an_encoding_that_does_not_read_like_ascii_are_refused(sound, tmp_path):
    """lxml, with which fmpy reads the description, decodes UTF-7."""
    hidden = '<!DOCTYPE a [<!ENTITY b "c">]><a/>'.replace("<", "+ADw-").replace("!", "+ACE-")
    data = b'<?xml version="1.0" encoding="UTF-7"?>' + hidden.encode()
    (found,) = check(with_member(sound, tmp_path, "extra/other.xml", data))
    assert found.message == "has the encoding UTF-7; expected UTF-8"


@pytest.mark.slow
def test_a_library_for_another_processor_is_no_fault(sound, tmp_path):
    """FMI 2 has one folder for 64-bit Linux: an ELF header of another machine says that it cannot run here."""
    contents = dict(sound)
    (name,) = [n for n in contents if n.startswith("binaries/linux64/")]
    library = bytearray(contents[name])
    library[18:20] = struct.pack("<H", 0xF3)  # RISC-V
    found = check(written(tmp_path, {**contents, name: bytes(library)}))
    assert [(p.check, p.severity) for p in found] == [("run", "warning")]


def messages(found, severity="error"):
    return [p.message for p in found if p.severity == severity]


@pytest.mark.parametrize(("member", "message"), [
    ("resources/" + "a" * 300, "the path is too long for a file"),
    ("resources/" + "a/" * 600 + "b", "the path is too long for a file"),
    ("binaries", "is a file and a folder"),
    ("ModelDescription.xml", "differs from ModelDescription.xml by upper and lower case alone"),
])  # fmt: skip
def test_paths_that_cannot_be_unpacked_everywhere_are_refused(member, message, sound, tmp_path):
    found = check(written(tmp_path, {**sound, member: b"<a/>"}))
    assert [m for m in messages(found) if m.startswith(message)]


def test_an_archive_without_members_and_damaged_ones(sound, tmp_path):
    assert messages(check(written(tmp_path, {}))) == ["has no modelDescription.xml at its top"]
    (said,) = messages(check(written(tmp_path, {f"model/{name}": data for name, data in sound.items()})))
    assert said == "has no modelDescription.xml at its top: it is in the folder 'model', whose contents belong at the top"
    (said,) = messages(check(written(tmp_path, {"SystemStructure.ssd": b"<a/>"})))
    assert said.endswith("it is a system of FMUs, which motofmi cosimulate --ssp runs")
    path = written(tmp_path, sound)
    data = bytearray(path.read_bytes())
    place = data.find(b"modelDescription.xml") + 200
    data[place : place + 50] = bytes(50)
    path.write_bytes(data)
    assert "is no readable zip archive" in messages(check(path))[0]


@pytest.mark.parametrize(("change", "message"), [
    (lambda xml: xml.replace(b'fmiVersion="2.0"', b'fmiVersion="1.0"'), "fmiVersion '1.0' is not checked (valid: 2.0, 3.0)"),
    (lambda xml: xml.replace(b'fmiVersion="2.0"', b""), "fmiVersion None is not checked (valid: 2.0, 3.0)"),
    (lambda xml: xml.replace(b"Passive", b"\xff\xfe"), "is no XML: not well-formed"),
    (lambda xml: xml.replace(b"UTF-8", b"klingon"), "has the encoding KLINGON; expected UTF-8"),
    (lambda xml: b"", "is no XML: no element found"),
])  # fmt: skip
def test_a_description_that_cannot_be_read_is_one_error(change, message, sound, tmp_path):
    (found,) = messages(
        check(written(tmp_path, {**sound, "modelDescription.xml": change(sound["modelDescription.xml"])}))
    )
    assert found.startswith(message)


@pytest.mark.slow
@pytest.mark.parametrize("depth", [300, 100_000])
def test_deeply_nested_xml_is_survived(depth, sound, tmp_path):
    xml = b'<fmiModelDescription fmiVersion="2.0">' + b"<a>" * depth + b"</a>" * depth + b"</fmiModelDescription>"
    assert messages(check(written(tmp_path, {**sound, "modelDescription.xml": xml})))


@pytest.mark.slow
@pytest.mark.parametrize("library", [b"", b"text", "cut", "folder"])
def test_a_library_that_is_none_is_reported(library, sound, tmp_path):
    contents = dict(sound)
    (name,) = [n for n in contents if n.startswith("binaries/")]
    whole = contents.pop(name)
    if library == "folder":
        contents[f"{name}/file"] = b""
    else:
        contents[name] = whole[:3000] if library == "cut" else library
    found = check(written(tmp_path, contents))
    assert {p.check for p in found if p.severity == "error"} <= {"load", "identifier", "binary"} and messages(found)


IN_OUTPUTS = b"(void)sign, (void)heaviside;\n"


def with_outputs(code, tmp_path):
    return changed_code(IN_OUTPUTS, IN_OUTPUTS.strip() + code + b"\n", tmp_path)


@pytest.mark.slow
def test_what_an_fmu_prints_is_not_taken_for_a_report(tmp_path):
    lie = rb'{ extern int printf(const char *, ...); extern void exit(int); printf("\n{\"trial\": \"end\"}\n"); exit(0); }'
    assert [m for m in messages(check(with_outputs(lie, tmp_path))) if "ended its process with status 0" in m]


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(os, "killpg"), reason="processes that start others")
def test_what_an_fmu_has_started_ends_with_the_check(tmp_path):
    mark = tmp_path / "alive"
    code = f'{{ extern int fork(void); extern unsigned sleep(unsigned); extern int creat(const char *, int); if (fork() == 0) {{ sleep(3); creat("{mark}", 0600); }} sleep(100); }}'
    assert [m for m in messages(check(with_outputs(code.encode(), tmp_path), time_limit=2)) if "did not finish within 2 s" in m]
    time.sleep(3.5)
    assert not mark.exists()


CHECK = """
from fmus.checks.problem import Problem

STAGE = "description"


def check(fmu):
    return [Problem("licence", "warning", "names no licence", "modelDescription.xml")] if fmu.root.get("license") is None else []
"""


@pytest.mark.slow
def test_a_check_is_one_file(sound, tmp_path):
    """A new file in the folder of the checks is applied: its problem is in the list and in the command's output."""
    shutil.copytree(ROOT / "fmus", tmp_path / "fmus", ignore=shutil.ignore_patterns("__pycache__"))
    (tmp_path / "fmus" / "checks" / "licence.py").write_text(CHECK, "utf-8")
    contents = {**sound, "modelDescription.xml": re.sub(rb' license="[^"]*"', b"", sound["modelDescription.xml"])}
    path = written(tmp_path, contents)
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(tmp_path), str(ROOT)])}
    done = subprocess.run(
        [sys.executable, "-m", "motofmi", "check", str(path)],
        env=environment,
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert "warning licence: names no licence" in " ".join(done.stdout.split()), done
