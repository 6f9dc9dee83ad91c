"""Systems of FMUs in one file: SSP archives, versions 1.0 and 2.0, written for any wiring and read back.

    SystemStructure.ssd    components, their connectors with units, connections, parameter bindings
    resources/NAME.fmu     the FMUs
    resources/NAME.ssv     parameter sets, and .ssm parameter mappings, of other tools

package      the files of an archive
structure    systems, components, connections and bindings as they are written
parameters   values of parameter sets, renamed and transformed by mappings
units        definitions of units, and conversions
flattening   nested systems as one: components by name, the outputs that drive their inputs, their values
converter    a connection that converts a unit or has a linear transformation, as a subsystem
reading      the FMUs, initialised
writing      an archive from FMUs and a wiring

Standard: System Structure and Parameterization, Modelica Association, 1.0 (2019) and 2.0 (2024).
"""

from fmus.cosimulation.ssp.reading import SspSystem, read_ssp
from fmus.cosimulation.ssp.writing import write_ssp

__all__ = ["SspSystem", "read_ssp", "write_ssp"]
