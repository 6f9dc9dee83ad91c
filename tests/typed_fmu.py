"""An FMU of another origin (tests/c/typed_fmu.c) with parameters of every type of FMI 2.0, and with units or without."""

import subprocess
import tempfile
import zipfile
from functools import cache
from pathlib import Path

import fmpy

from fmus.export.compilers import host, host_compiler
from tests import ROOT

HEADERS = Path(fmpy.__file__).parent / "c-code"
DESCRIPTION = """<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="typed"{guid}>
  <CoSimulation modelIdentifier="typed"/>
  {units}
  <TypeDefinitions><SimpleType name="Mode"><Enumeration><Item name="slow" value="1"/><Item name="fast" value="2"/></Enumeration></SimpleType></TypeDefinitions>
  <DefaultExperiment startTime="0" stopTime="2" stepSize="0.1"/>
  <ModelVariables>
    <ScalarVariable name="u" valueReference="0" causality="input"><Real start="0"{speed}/></ScalarVariable>
    <ScalarVariable name="gain" valueReference="1" causality="parameter" variability="fixed"><Real start="1"/></ScalarVariable>
    <ScalarVariable name="flag" valueReference="0" causality="parameter" variability="fixed"><Boolean start="false"/></ScalarVariable>
    <ScalarVariable name="count" valueReference="0" causality="parameter" variability="fixed"><Integer start="0"/></ScalarVariable>
    <ScalarVariable name="mode" valueReference="1" causality="parameter" variability="fixed"><Enumeration declaredType="Mode" start="1"/></ScalarVariable>
    <ScalarVariable name="label" valueReference="0" causality="parameter" variability="fixed"><String start=""/></ScalarVariable>
    <ScalarVariable name="y" valueReference="2" causality="output"><Real{speed}/></ScalarVariable>
    <ScalarVariable name="seen_flag" valueReference="3" causality="output"><Real/></ScalarVariable>
    <ScalarVariable name="seen_count" valueReference="4" causality="output"><Real/></ScalarVariable>
    <ScalarVariable name="seen_mode" valueReference="5" causality="output"><Real/></ScalarVariable>
    <ScalarVariable name="label_length" valueReference="6" causality="output"><Real/></ScalarVariable>
    {more}
  </ModelVariables>
  <ModelStructure><Outputs><Unknown index="7" dependencies="1"/><Unknown index="8" dependencies=""/><Unknown index="9" dependencies=""/>
    <Unknown index="10" dependencies=""/><Unknown index="11" dependencies=""/></Outputs></ModelStructure>
</fmiModelDescription>
"""
MORE = """
    <ScalarVariable name="end_time" valueReference="7" causality="parameter" variability="fixed"><Real start="1e300"/></ScalarVariable>
    <ScalarVariable name="steps_wanted" valueReference="2" causality="input" variability="discrete"><Integer start="0"/></ScalarVariable>
    <ScalarVariable name="shown_flag" valueReference="0" causality="output" variability="discrete"><Boolean/></ScalarVariable>
    <ScalarVariable name="shown_mode" valueReference="1" causality="output" variability="discrete"><Enumeration declaredType="Mode"/></ScalarVariable>
    <ScalarVariable name="shown_count" valueReference="0" causality="output" variability="discrete"><Integer/></ScalarVariable>
    <ScalarVariable name="shown_label" valueReference="0" causality="output" variability="discrete"><String/></ScalarVariable>
"""
UNITS = {
    "m/s": '<Unit name="m/s"><BaseUnit m="1" s="-1"/></Unit>',
    "km/h": '<Unit name="km/h"><BaseUnit m="1" s="-1" factor="0.277777777777777778"/></Unit>',
}


@cache
def _library() -> bytes:
    with tempfile.TemporaryDirectory() as folder:
        library = Path(folder, "typed")
        subprocess.run([*(host_compiler() or ("cc",)), "-shared", "-fPIC", "-O1", f"-I{HEADERS}",
                        str(ROOT / "tests" / "c" / "typed_fmu.c"), "-o", str(library)], check=True)  # fmt: skip
        return library.read_bytes()


def typed_fmu(path: Path, unit: str = "m/s", *, more: bool = False, guid: str = ' guid="{typed}"') -> Path:
    """The archive; `u` and `y` have that unit, or none for an empty text. With `more` it has outputs of every type, and
    the time at which it asks for the end of the simulation as a parameter."""
    definitions = f"<UnitDefinitions>{UNITS[unit]}</UnitDefinitions>" if unit else ""
    with zipfile.ZipFile(path, "w") as archive:
        description = DESCRIPTION.format(
            units=definitions, speed=f' unit="{unit}"' if unit else "", more=MORE if more else "", guid=guid
        )
        archive.writestr("modelDescription.xml", description)
        archive.writestr(f"binaries/{host().folder}/typed{host().suffix}", _library())
    return path
