"""Every fault is reported with its sentence, within its limit, and leaves neither process nor file."""

import contextlib
import os
import subprocess
import time
import zipfile
from dataclasses import replace

import psutil
import pytest

from fmus.checks.check import Limits, check
from fmus.checks.host import host_folder
from tests import sampled
from tests.fmus.checks import bench, faults

pytestmark = [pytest.mark.slow, pytest.mark.skipif(os.name == "nt", reason="faults with signals")]
PATIENT = Limits(time=20.0, memory=300 * 2**20, file_size=2**23)
SHORT = replace(PATIENT, time=0.6)


def checked(path, limits=PATIENT):
    return check(path, limits, other_tools=False)


def assert_said(found, name, severity, message):
    said = [p for p in found if p.check == name and p.severity == severity and message in p.message]
    assert said, "\n".join(map(str, found))
    return said[0]


@pytest.mark.parametrize("fault", sampled(faults.XML, 5))
def test_a_faulty_description(fault, tmp_path):
    (old, new), name, severity, message = faults.XML[fault]
    assert bench.BENCH2.count(old) >= 1
    found = checked(bench.written(tmp_path / "faulty.fmu", bench.BENCH2.replace(old, new, 1)))
    problem = assert_said(found, name, severity, message)
    assert problem.section or name == "description"


@pytest.mark.parametrize("fault", sampled(faults.OTHER_FILES, 5))
def test_a_faulty_file_beside_the_description(fault, tmp_path):
    file, text, name, message = faults.OTHER_FILES[fault]
    assert_said(checked(bench.written(tmp_path / "faulty.fmu", bench.BENCH2, files={file: text.encode()})), name, "error", message)


def test_files_beside_the_description_without_fault(tmp_path):
    files = {faults.T: faults.TERMINALS.encode(), faults.B: faults.BUILD.encode()}
    found = checked(bench.written(tmp_path / "good.fmu", bench.BENCH2, files=files))
    assert [p.message for p in found] == ["no binary, only source code", *(p.message for p in found[1:] if p.check == "run")]


@pytest.mark.parametrize("fault", sampled(faults.FAULTS, 5))
def test_a_faulty_binary(fault, libraries, tmp_path, monkeypatch):
    kind, word, name, severity, message = faults.FAULTS[fault]
    monkeypatch.setenv("TEST_OF_A_FAULT", str(tmp_path))  # inherited by whatever the check and the FMU start
    began = time.monotonic()
    path = bench.written(tmp_path / "faulty.fmu", bench.only(kind), libraries("fmu2.c"), fault=word)
    problem = assert_said(checked(path, SHORT if "did not finish" in message else PATIENT), name, severity, message)
    assert time.monotonic() - began < 60 and not leftovers(tmp_path)
    assert {path} == set(tmp_path.iterdir())
    if " returns " in message and "instance" not in message:
        assert problem.call and problem.status and problem.section.startswith("FMI 2.0.4") and ("42 words" in problem.log or "status 7" in message)


def leftovers(mark):
    """Processes that a test has started."""
    found = []
    for process in psutil.process_iter():
        with contextlib.suppress(psutil.Error, OSError):
            if process.environ().get("TEST_OF_A_FAULT") == str(mark) and process.status() != psutil.STATUS_ZOMBIE:
                found.append(process)
    return found


@pytest.mark.parametrize("fault", sampled(faults.LIBRARIES, 5))
def test_a_faulty_library(fault, libraries, tmp_path):
    flags, name, message = faults.LIBRARIES[fault]
    path = bench.written(tmp_path / "faulty.fmu", bench.only(faults.CS), libraries("fmu2.c", *flags))
    assert_said(checked(path, SHORT if "finish" in message else PATIENT), name, "error", message)


def test_a_library_that_is_not_there(libraries, tmp_path):
    """A dependency that the loader does not find, and files that are no library."""
    stub = tmp_path / "libnowhere.so"
    stub.write_bytes(bench.compiled("fmu2.c", tmp_path / "stub.so", "-Wl,-soname,libnowhere.so.7"))
    library = bench.compiled("fmu2.c", tmp_path / "bench.so", "-Wl,--no-as-needed", str(stub))
    problem = assert_said(checked(bench.written(tmp_path / "a.fmu", bench.only(faults.CS), library)), "load", "error", "libnowhere.so.7")
    assert "cannot open shared object file" in problem.message
    for data, what in ((b"no library", "text"), (b"", "an empty file"), (library[:3000], "cut")):
        found = checked(bench.written(tmp_path / "b.fmu", bench.only(faults.CS), data))
        assert_said(found, "binary", "error", "is cut off after 3000 bytes" if what == "cut" else f"is no shared library but {what}")


ELF = {
    "noise after the first bytes": (lambda data: data[:7] + bytes(range(256)) * 16, "is no shared library but an ELF file with a damaged header"),
    "no header after the first bytes": (lambda data: data[:7], "is no shared library but the beginning of an ELF file"),
    "other byte order": (lambda data: data[:5] + b"\x02" + data[6:], "is no shared library but an ELF file with a damaged header"),
    "executable": (lambda data: data[:16] + b"\x02" + data[17:], "is no shared library but an ELF file of another kind (executable)"),
}  # fmt: skip


@pytest.mark.skipif(host_folder("2") != "linux64", reason="ELF is the format of Linux")
@pytest.mark.parametrize("fault", ELF)
def test_an_elf_file_that_is_no_library(fault, libraries, tmp_path):
    change, message = ELF[fault]
    found = checked(bench.written(tmp_path / "a.fmu", bench.only(faults.CS), change(libraries("fmu2.c"))))
    assert_said(found, "binary", "error", message)
    assert {p.check for p in found} <= {"binary", "load"} and all("\n" not in p.message for p in found)
    assert all("find_library" not in p.message for p in found)


ENCODINGS = {"UTF-16": "utf-16", "UTF-16LE": "utf-16-le", "ISO-8859-1": "latin-1"}


@pytest.mark.parametrize("encoding", ENCODINGS)
def test_a_description_in_another_encoding(encoding, tmp_path):
    xml = bench.BENCH2.replace("UTF-8", encoding)
    found = checked(bench.written(tmp_path / "faulty.fmu", xml.encode(ENCODINGS[encoding])))
    problem = assert_said(found, "encoding", "error", f"has the encoding {encoding.removesuffix('LE')}; expected UTF-8")
    assert problem.section == "FMI 2.0.4, 2.2"


@pytest.mark.parametrize("text", [bench.BENCH2.encode("utf-8-sig"), bench.BENCH2.replace(' encoding="UTF-8"', "").encode(), bench.BENCH2.replace("UTF-8", "us-ascii").encode()])
def test_descriptions_that_are_utf_8(text, tmp_path):
    assert "encoding" not in {p.check for p in checked(bench.written(tmp_path / "good.fmu", text))}


def test_wrong_dependencies(libraries, tmp_path):
    """y changes with u, which its list leaves out; the binary is that of the correct FMU."""
    xml = bench.BENCH2.replace('dependencies="1 3" dependenciesKind="dependent dependent"', 'dependencies="1"')
    found = checked(bench.written(tmp_path / "faulty.fmu", bench.only(faults.ME, xml), libraries("fmu2.c")))
    assert_said(found, "dependencies", "error", "y changes with u, which its dependencies leave out")


def test_more_event_indicators_than_the_binary_has(libraries, tmp_path):
    xml = bench.BENCH2.replace('numberOfEventIndicators="1"', 'numberOfEventIndicators="3"')
    found = checked(bench.written(tmp_path / "faulty.fmu", bench.only(faults.ME, xml), libraries("fmu2.c")))
    assert_said(found, "continuous", "error", "writes 1 of the 3 event indicators of the description")


def test_a_fault_in_the_description_does_not_stop_the_trials(libraries, tmp_path):
    xml = bench.BENCH2.replace('<Unknown index="2" dependencies="1 3 5" />', "")
    found = checked(bench.written(tmp_path / "faulty.fmu", bench.only(faults.CS, xml), libraries("fmu2.c"), fault="error_step"))
    assert_said(found, "structure", "error", "InitialUnknowns does not list der(x)")
    assert_said(found, "run", "error", "fmi2DoStep returns fmi2Error")


def damaged(data, change):
    return change(bytearray(data))


def cut(data):
    return data[: len(data) // 2]


def flip(data):
    place = data.find(b"modelDescription.xml") + 60
    data[place : place + 40] = bytes(40)
    return data


ZIPS = {
    "cut": (cut, "is no readable zip archive"), "text": (lambda data: b"no archive", "is no readable zip archive"),
    "empty": (lambda data: b"", "is no readable zip archive"), "damaged": (flip, "is no readable zip archive"),
}  # fmt: skip


@pytest.mark.parametrize("fault", sampled(ZIPS, 3))
def test_a_damaged_archive(fault, tmp_path):
    change, message = ZIPS[fault]
    path = bench.written(tmp_path / "faulty.fmu", bench.BENCH2)
    path.write_bytes(damaged(path.read_bytes(), change))
    assert_said(checked(path), "archive", "error", message)


MEMBERS = {
    "path upwards": ("../outside", b"", "the path leaves the folder"), "absolute path": ("/tmp/outside", b"", "the path leaves the folder"),
    "drive": ("C:/outside", b"", "the path leaves the folder"), "long name": ("resources/" + 300 * "a", b"", "the path is too long"),
    "file and folder": ("sources", b"x", "is a file and a folder"), "two spellings": ("MODELDESCRIPTION.xml", b"<a/>", "by upper and lower case alone"),
    "bomb": ("resources/zeros", bytes(2**23), "times its size"), "twice": ("sources/bench.c", b"other", "is there twice, with different contents"),
}  # fmt: skip


@pytest.mark.filterwarnings("ignore:Duplicate name")
@pytest.mark.parametrize("fault", sampled(MEMBERS, 3))
def test_a_harmful_member(fault, tmp_path):
    name, data, message = MEMBERS[fault]
    path = bench.written(tmp_path / "faulty.fmu", bench.BENCH2)
    with zipfile.ZipFile(path, "a", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr(name, data)
    assert_said(checked(path), "archive", "error", message)


def test_markup_in_data_is_data(tmp_path):
    """The command prints names and units as they are, whatever they look like."""
    xml = bench.BENCH2.replace('<Real unit="1" min="0" max="1" />', '<Real unit="furlong[/red]" min="2" max="1" />').replace('name="bounded"', 'name="a[/red]b"')
    path = bench.written(tmp_path / "faulty.fmu", xml)
    done = subprocess.run([os.sys.executable, "-m", "motofmi", "check", str(path)], capture_output=True, text=True, check=False)
    assert done.returncode == 1 and "unit [furlong[/red]] is not defined (a[/red]b)" in done.stdout, done


def test_the_corpus_has_at_least_eighty_archives():
    assert sum(map(len, (faults.XML, faults.OTHER_FILES, faults.FAULTS, faults.LIBRARIES, ZIPS, MEMBERS))) >= 80
