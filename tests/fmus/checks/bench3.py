"""The description of the FMU of FMI 3 in `c/fmu3.c`."""

INTEGERS = ("Int8", "UInt8", "Int16", "UInt16", "Int32", "UInt32", "Int64", "UInt64")
FIRST = 9
INTEGER_VARIABLES = "\n".join(
    f'    <{t} name="{t}_in" valueReference="{FIRST + 2 * i}" causality="input" start="{i}" />'
    f'<{t} name="{t}_out" valueReference="{FIRST + 2 * i + 1}" causality="output" />'
    for i, t in enumerate(INTEGERS)
)
SCALAR_OUTPUTS = (8, *range(FIRST + 1, FIRST + 16, 2), 26, 28, 30, 32)
BENCH3 = f"""<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="3.0" modelName="bench" instantiationToken="{{bench}}" variableNamingConvention="structured">
  <ModelExchange modelIdentifier="bench" canGetAndSetFMUState="true" canSerializeFMUState="true" providesDirectionalDerivatives="true"
      providesAdjointDerivatives="true" />
  <CoSimulation modelIdentifier="bench" canGetAndSetFMUState="true" canSerializeFMUState="true" providesDirectionalDerivatives="true"
      providesAdjointDerivatives="true" canHandleVariableCommunicationStepSize="true" hasEventMode="true"
      providesIntermediateUpdate="true" canReturnEarlyAfterIntermediateUpdate="true" mightReturnEarlyFromDoStep="true" />
  <UnitDefinitions><Unit name="1"><BaseUnit /></Unit><Unit name="s"><BaseUnit s="1" /></Unit></UnitDefinitions>
  <TypeDefinitions>
    <EnumerationType name="colours"><Item name="red" value="1" /><Item name="blue" value="2" /></EnumerationType>
  </TypeDefinitions>
  <LogCategories><Category name="logStatusError" /></LogCategories>
  <DefaultExperiment startTime="0" stopTime="2" stepSize="0.02" />
  <ModelVariables>
    <Float64 name="time" valueReference="0" causality="independent" variability="continuous" unit="s" />
    <UInt64 name="n" valueReference="1" causality="structuralParameter" variability="tunable" start="2" min="1" max="4" />
    <Float64 name="A" valueReference="2" causality="parameter" variability="tunable" unit="1" start="-1 0 0 -2"><Dimension valueReference="1" /><Dimension valueReference="1" /></Float64>
    <Float64 name="u" valueReference="3" causality="input" intermediateUpdate="true" unit="1" start="1 2"><Dimension valueReference="1" /></Float64>
    <Float64 name="x" valueReference="4" causality="local" initial="exact" unit="1" start="0 1"><Dimension valueReference="1" /></Float64>
    <Float64 name="der(x)" valueReference="5" unit="1" derivative="4"><Dimension valueReference="1" /></Float64>
    <Float64 name="y" valueReference="6" causality="output" intermediateUpdate="true" unit="1"><Dimension valueReference="1" /><Alias name="shown.y" /></Float64>
    <Float32 name="Float32_in" valueReference="7" causality="input" unit="1" start="0.1" /><Float32 name="Float32_out" valueReference="8" causality="output" unit="1" />
{INTEGER_VARIABLES}
    <Boolean name="truth_in" valueReference="25" causality="input" start="false" /><Boolean name="truth_out" valueReference="26" causality="output" />
    <String name="word_in" valueReference="27" causality="input"><Start value="grey" /></String><String name="word_out" valueReference="28" causality="output" />
    <Binary name="data_in" valueReference="29" causality="input"><Start value="64617461" /></Binary><Binary name="data_out" valueReference="30" causality="output" maxSize="4" />
    <Enumeration name="colour_in" valueReference="31" causality="input" declaredType="colours" start="1" />
    <Enumeration name="colour_out" valueReference="32" causality="output" declaredType="colours" min="1" max="2" />
    <Clock name="trigger" valueReference="33" causality="input" intervalVariability="triggered" priority="1" />
    <Clock name="tick" valueReference="34" causality="output" intervalVariability="triggered" />
    <Int32 name="ticks" valueReference="35" causality="output" clocks="33" />
    <Float64 name="z" valueReference="36" unit="1" />
    <Clock name="timer" valueReference="37" causality="input" intervalVariability="countdown" priority="2" />
    <Binary name="note" valueReference="38" causality="output" clocks="33" mimeType="text/plain" maxSize="16" />
    <Clock name="sampler" valueReference="39" causality="input" intervalVariability="constant" intervalDecimal="0.1" priority="0" />
    <Int32 name="samples" valueReference="40" causality="output" clocks="39" />
  </ModelVariables>
  <ModelStructure>
    <Output valueReference="6" dependencies="3 4" />
    {"".join(f'<Output valueReference="{r}" />' for r in SCALAR_OUTPUTS)}
    <Output valueReference="34" /><Output valueReference="35" />
    <Output valueReference="38" /><Output valueReference="40" />
    <ContinuousStateDerivative valueReference="5" dependencies="2 3 4" />
    <InitialUnknown valueReference="5" /><InitialUnknown valueReference="6" />
    {"".join(f'<InitialUnknown valueReference="{r}" />' for r in SCALAR_OUTPUTS)}
    <EventIndicator valueReference="36" />
  </ModelStructure>
</fmiModelDescription>
"""
