"""Whether this machine can run an FMU: the folder of its binaries, and the processor that they are for."""

import platform
import struct
from pathlib import Path

SHARED_OBJECT, KINDS = 3, {1: "object file", 2: "executable", 4: "core dump"}  # e_type of an ELF header
PROCESSORS = {0x3E: "x86_64", 0xB7: "aarch64"}  # e_machine of an ELF header


def damaged_elf(data: bytes) -> str:
    """What an ELF file is that is no shared library; empty for one that may be (System V ABI, ELF header)."""
    if len(data) < 24:
        return "the beginning of an ELF file"
    order = "<" if data[5] == 1 else ">"
    kind, _, version = struct.unpack(f"{order}HHI", data[16:24])
    if data[4] not in (1, 2) or data[5] not in (1, 2) or data[6] != 1 or version != 1:
        return "an ELF file with a damaged header"
    if kind != SHARED_OBJECT:
        return f"an ELF file of another kind ({KINDS.get(kind, f'type {kind}')})"
    return ""


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

    FMI 2 has one folder for 64-bit Linux, whatever the processor. A damaged header names no processor.
    """
    for library in filter(Path.is_file, folder.glob("*.so")):
        header = library.read_bytes()[:24]
        if header[:4] == b"\x7fELF" and not damaged_elf(header):
            processor = PROCESSORS.get(
                int.from_bytes(header[18:20], "little" if header[5] == 1 else "big"), "another processor"
            )
            if processor != {"arm64": "aarch64", "amd64": "x86_64"}.get(
                platform.machine().lower(), platform.machine().lower()
            ):
                return processor
    return ""
