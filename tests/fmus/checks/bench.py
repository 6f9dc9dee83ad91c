"""Small FMUs of FMI 2 and 3 for tests of the check, compiled once per session, and archives of them with faults."""

import re
import shlex
import subprocess
import zipfile
from pathlib import Path

import fmpy

from fmus.checks.host import host_folder, library_suffix
from fmus.export.compilers import host_compiler

SOURCES = Path(__file__).parent / "c"
HEADERS = Path(fmpy.__file__).parent / "c-code"

BENCH2 = """<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="bench" guid="{bench}" generationDateAndTime="2024-01-31T12:00:00Z"
    variableNamingConvention="structured" numberOfEventIndicators="1">
  <ModelExchange modelIdentifier="bench" canGetAndSetFMUstate="true" canSerializeFMUstate="true" providesDirectionalDerivative="true" />
  <CoSimulation modelIdentifier="bench" canHandleVariableCommunicationStepSize="true" maxOutputDerivativeOrder="1"
      canGetAndSetFMUstate="true" canSerializeFMUstate="true" providesDirectionalDerivative="true" />
  <UnitDefinitions>
    <Unit name="1"><BaseUnit /></Unit>
    <Unit name="m"><BaseUnit m="1" /><DisplayUnit name="mm" factor="1000" /></Unit>
  </UnitDefinitions>
  <TypeDefinitions>
    <SimpleType name="colour"><Enumeration><Item name="red" value="1" /><Item name="blue" value="2" /></Enumeration></SimpleType>
    <SimpleType name="length"><Real unit="m" /></SimpleType>
  </TypeDefinitions>
  <LogCategories><Category name="logStatusError" /></LogCategories>
  <DefaultExperiment startTime="0" stopTime="1" stepSize="0.01" />
  <ModelVariables>
    <ScalarVariable name="x" valueReference="0" causality="local" initial="exact"><Real unit="1" start="1" /></ScalarVariable>
    <ScalarVariable name="der(x)" valueReference="1"><Real unit="1" derivative="1" /></ScalarVariable>
    <ScalarVariable name="u" valueReference="2" causality="input"><Real unit="1" start="0" max="100" /></ScalarVariable>
    <ScalarVariable name="y" valueReference="3" causality="output"><Real declaredType="length" displayUnit="mm" /></ScalarVariable>
    <ScalarVariable name="k" valueReference="4" causality="parameter" variability="fixed"><Real unit="1" min="0" start="2" /></ScalarVariable>
    <ScalarVariable name="g" valueReference="5" causality="parameter" variability="tunable"><Real unit="1" start="0.25" /></ScalarVariable>
    <ScalarVariable name="bounded" valueReference="6"><Real unit="1" min="0" max="1" /></ScalarVariable>
    <ScalarVariable name="events" valueReference="0" causality="output" variability="discrete"><Integer /></ScalarVariable>
    <ScalarVariable name="integer_in" valueReference="1" causality="input" variability="discrete"><Integer start="7" /></ScalarVariable>
    <ScalarVariable name="integer_out" valueReference="2" causality="output" variability="discrete"><Integer min="-10" max="10" /></ScalarVariable>
    <ScalarVariable name="switch_in" valueReference="0" causality="input" variability="discrete"><Boolean start="false" /></ScalarVariable>
    <ScalarVariable name="switch_out" valueReference="1" causality="output" variability="discrete"><Boolean /></ScalarVariable>
    <ScalarVariable name="colour" valueReference="0" causality="parameter" variability="fixed"><String start="grey" /></ScalarVariable>
    <ScalarVariable name="shown.colour" valueReference="1" causality="output" variability="discrete"><String /></ScalarVariable>
  </ModelVariables>
  <ModelStructure>
    <Outputs>
      <Unknown index="4" dependencies="1 3" dependenciesKind="dependent dependent" />
      <Unknown index="8" /><Unknown index="10" /><Unknown index="12" /><Unknown index="14" />
    </Outputs>
    <Derivatives><Unknown index="2" dependencies="1 3" /></Derivatives>
    <InitialUnknowns>
      <Unknown index="2" dependencies="1 3 5" /><Unknown index="4" dependencies="1 3 6" />
      <Unknown index="8" /><Unknown index="10" /><Unknown index="12" /><Unknown index="14" />
    </InitialUnknowns>
  </ModelStructure>
</fmiModelDescription>
"""
BALL = """<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="ball" guid="{bench}" numberOfEventIndicators="1">
  <ModelExchange modelIdentifier="ball" canGetAndSetFMUstate="true" canSerializeFMUstate="true" />
  <CoSimulation modelIdentifier="ball" canHandleVariableCommunicationStepSize="true" canGetAndSetFMUstate="true" canSerializeFMUstate="true" />
  <UnitDefinitions>
    <Unit name="m"><BaseUnit m="1" /></Unit><Unit name="m/s"><BaseUnit m="1" s="-1" /></Unit>
    <Unit name="m/s2"><BaseUnit m="1" s="-2" /></Unit><Unit name="1"><BaseUnit /></Unit>
  </UnitDefinitions>
  <DefaultExperiment startTime="0" stopTime="3" stepSize="0.01" />
  <ModelVariables>
    <ScalarVariable name="h" valueReference="0" causality="output" initial="exact"><Real unit="m" start="1" reinit="true" /></ScalarVariable>
    <ScalarVariable name="v" valueReference="1" causality="output" initial="exact"><Real unit="m/s" start="0" reinit="true" /></ScalarVariable>
    <ScalarVariable name="der(h)" valueReference="2"><Real unit="m/s" derivative="1" /></ScalarVariable>
    <ScalarVariable name="der(v)" valueReference="3"><Real unit="m/s2" derivative="2" /></ScalarVariable>
    <ScalarVariable name="g" valueReference="4" causality="parameter" variability="fixed"><Real unit="m/s2" start="9.81" /></ScalarVariable>
    <ScalarVariable name="e" valueReference="5" causality="parameter" variability="fixed"><Real unit="1" start="0.7" /></ScalarVariable>
  </ModelVariables>
  <ModelStructure>
    <Outputs><Unknown index="1" dependencies="" /><Unknown index="2" dependencies="" /></Outputs>
    <Derivatives><Unknown index="3" /><Unknown index="4" /></Derivatives>
    <InitialUnknowns><Unknown index="3" /><Unknown index="4" /></InitialUnknowns>
  </ModelStructure>
</fmiModelDescription>
"""


def compiled(source: str, out: Path, *flags: str) -> bytes:
    """A shared library of a source file in the folder `c`."""
    command = [*host_compiler(), "-std=gnu99", "-O1", "-shared", "-fPIC", f"-I{HEADERS}", *flags, str(SOURCES / source), "-o", str(out), "-lm"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, f"{shlex.join(command)}\n{done.stderr}"
    return out.read_bytes()


def only(kind: str, xml: str = BENCH2) -> str:
    """The description with one kind alone, of those that it has or of scheduled execution."""
    kinds = re.compile(r"  <(ModelExchange|CoSimulation)\b[^>]*/>\n", flags=re.DOTALL)
    if kind == "ScheduledExecution":
        return kinds.sub("", kinds.sub('  <ScheduledExecution modelIdentifier="bench" />\n', xml, count=1))
    return kinds.sub(lambda found: found[0] if found[1] == kind else "", xml)


def written(path: Path, xml: str | bytes, library: bytes | None = None, identifier: str = "bench", files: dict | None = None, fault: str = "") -> Path:
    """An archive of a description, its library for this machine, more files, and the word that makes the library
    faulty."""
    text = xml.encode() if isinstance(xml, str) else xml
    members = {"modelDescription.xml": text, **(files or {})}
    if library is None:
        members.setdefault(f"sources/{identifier}.c", b"")
    else:
        version = "3" if b'fmiVersion="3' in text else "2"
        members[f"binaries/{host_folder(version)}/{identifier}{library_suffix()}"] = library
    if fault:
        members["resources/fault.txt"] = fault.encode()
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in members.items():
            archive.writestr(name, data)
    return path
