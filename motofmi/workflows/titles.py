"""The displayed names of vehicles and devices in figures, tables and messages."""

LIBRARIES = ("motorcycle_", "rider_")  # prefixes of component names that are not displayed


def system_title(vehicle: str, device: str) -> str:
    """The displayed name of a vehicle with its devices, given the names of the components.

    >>> system_title("motorcycle_sharp_1971", "rider_mean_2011, damper_7.5")
    'sharp_1971 with mean_2011, damper_7.5'
    """
    if vehicle.endswith(".ssp"):  # the whole system
        return vehicle
    devices = ", ".join(displayed(name) for name in device.split(", "))
    return f"{displayed(vehicle)} without a device" if device == "none" else f"{displayed(vehicle)} with {devices}"


def displayed(name: str) -> str:
    """The name of a component without that of its library.

    >>> displayed("motorcycle_sharp_1971")
    'sharp_1971'
    """
    for library in LIBRARIES:
        name = name.removeprefix(library)
    return name
