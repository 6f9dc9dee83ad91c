"""The files of an archive beside its description and its code: documentation, icon, terminals, reference results."""

from fmus.export import documentation, icon, reference
from fmus.export.interface import Interface
from fmus.export.model_description3 import terminals


def files(interface: Interface, fmi: int, interpolates: bool = True) -> dict[str, bytes]:
    """The files by their path in the archive (FMI 2.0.4, 2.3; FMI 3.0, 2.5.1). A back end that holds inputs over a step
    does not meet reference results with inputs that move."""
    picture = icon.png(interface)
    found = {
        "documentation/index.html": documentation.index(interface),
        "terminalsAndIcons/terminalsAndIcons.xml": terminals(interface),
        "terminalsAndIcons/icon.png": picture,
        "terminalsAndIcons/icon.svg": icon.svg(interface),
        **(reference.files(interface) if interpolates else {}),
    }
    return found if fmi == 3 else {**found, "model.png": picture}
