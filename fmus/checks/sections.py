"""Sections of FMI 2.0.4 and FMI 3.0.2 that describe a call or a part of an FMU."""

# Call without its prefix `fmi2` or `fmi3` -> its section in each version; the longest beginning that matches counts.
OF_CALLS = {
    "2": {
        "GetTypesPlatform": "2.1.4", "GetVersion": "2.1.4", "SetDebugLogging": "2.1.5", "Instantiate": "2.1.5", "FreeInstance": "2.1.5",
        "SetupExperiment": "2.1.6", "EnterInitializationMode": "2.1.6", "ExitInitializationMode": "2.1.6", "Terminate": "2.1.6", "Reset": "2.1.6",
        "Get": "2.1.7", "Set": "2.1.7", "GetFMUstate": "2.1.8", "SetFMUstate": "2.1.8", "FreeFMUstate": "2.1.8", "Serialize": "2.1.8",
        "DeSerialize": "2.1.8", "GetDirectionalDerivative": "2.1.9", "SetTime": "3.2.1", "SetContinuousStates": "3.2.1",
        "EnterEventMode": "3.2.2", "NewDiscreteStates": "3.2.2", "EnterContinuousTimeMode": "3.2.2", "CompletedIntegratorStep": "3.2.2",
        "GetDerivatives": "3.2.2", "GetEventIndicators": "3.2.2", "GetContinuousStates": "3.2.2", "GetNominals": "3.2.2",
        "SetRealInputDerivatives": "4.2.1", "GetRealOutputDerivatives": "4.2.1", "DoStep": "4.2.2", "CancelStep": "4.2.2", "GetStatus": "4.2.3",
        "GetBooleanStatus": "4.2.3",
    },
    "3": {
        "GetVersion": "2.2.5", "Instantiate": "2.3.1", "FreeInstance": "2.3.1", "SetDebugLogging": "2.3.1", "Reset": "2.3.1",
        "EnterInitializationMode": "2.3.2", "EnterConfigurationMode": "2.3.2", "ExitInitializationMode": "2.3.3", "Terminate": "2.3.4",
        "EnterEventMode": "2.3.4", "EvaluateDiscreteStates": "2.3.5", "UpdateDiscreteStates": "2.3.5", "EnterContinuousTimeMode": "2.3.5",
        "EnterStepMode": "2.3.5", "ExitConfigurationMode": "2.3.6", "Get": "2.2.7.2", "Set": "2.2.7.2", "GetFMUState": "2.2.7.4",
        "SetFMUState": "2.2.7.4", "FreeFMUState": "2.2.7.4", "Serialize": "2.2.7.4", "Deserialize": "2.2.7.4", "GetClock": "2.2.8.4",
        "SetClock": "2.2.8.4", "GetInterval": "2.2.8.4", "GetShift": "2.2.8.4", "GetNumberOfVariableDependencies": "2.2.9",
        "GetVariableDependencies": "2.2.9", "GetDirectionalDerivative": "2.2.12.1", "GetAdjointDerivative": "2.2.12.2",
        "SetTime": "3.2.1", "SetContinuousStates": "3.2.1", "CompletedIntegratorStep": "3.2.1", "GetContinuousState": "3.2.1",
        "GetEventIndicators": "3.2.1", "GetNominals": "3.2.1", "GetNumberOfContinuousStates": "3.2.1", "GetNumberOfEventIndicators": "3.2.1",
        "GetOutputDerivatives": "4.1.2", "DoStep": "4.2.1", "ActivateModelPartition": "5.2.1",
    },
}  # fmt: skip
STATUS = {"2": "2.1.3", "3": "2.2.4"}
NAMES = {"2": "FMI 2.0.4", "3": "FMI 3.0"}


def section(version: str, two: str, three: str) -> str:
    """A section, as in `FMI 2.0.4, 2.2.8`, from its number in each version; "" where a version has none."""
    number = two if version == "2" else three
    return f"{NAMES[version]}, {number}" if number else ""


def of_call(name: str) -> str:
    """The section that describes a call, as `fmi2DoStep`."""
    version, rest = name[3:4], name[4:]
    numbers = OF_CALLS.get(version, {})
    fits = max((key for key in numbers if rest.startswith(key)), key=len, default="")
    return f"{NAMES[version]}, {numbers[fits]}" if fits else ""
