"""Whether this machine can run an FMU: the folder of its binaries, and the processor that they are for."""

import platform
from pathlib import Path

PROCESSORS = {0x3E: "x86_64", 0xB7: "aarch64"}  # e_machine of an ELF header


def host_folder(version: str) -> str:
    """The folder of this machine's binaries in an archive of FMI 2 or 3."""
    arm = platform.machine().lower() in ("arm64", "aarch64")
    system = {"Windows": ("win64", "windows"), "Darwin": ("darwin64", "darwin")}.get(
        platform.system(), ("linux64", "linux")
    )
    return system[0] if version == "2" else f"{'aarch64' if arm else 'x86_64'}-{system[1]}"


def library_suffix() -> str:
    """The suffix of this machine's shared libraries."""
    return {"Windows": ".dll", "Darwin": ".dylib"}.get(platform.system(), ".so")


def other_processor(folder: Path) -> str:
    """The processor that the Linux libraries in a folder are for, where it is not this machine's; else an empty text.

    FMI 2 has one folder for 64-bit Linux, whatever the processor.
    """
    for library in filter(Path.is_file, folder.glob("*.so")):
        header = library.read_bytes()[:20]
        if header[:4] == b"\x7fELF":
            processor = PROCESSORS.get(
                int.from_bytes(header[18:20], "little" if header[5] == 1 else "big"), "another processor"
            )
            if processor != {"arm64": "aarch64", "amd64": "x86_64"}.get(
                platform.machine().lower(), platform.machine().lower()
            ):
                return processor
    return ""
