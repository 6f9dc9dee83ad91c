"""The icon of an FMU: what its port shows of it, drawn from a few lines and circles, as PNG and as SVG.

A component that gives torques to a handlebar is a device, drawn as a handlebar with a torso; one that takes them is a
vehicle, drawn as two wheels and a frame; any other is drawn as a block with a spring.
"""

import struct
import zlib
from collections.abc import Sequence

import numpy as np

from fmus.export.interface import Interface

SIZE = 96  # pixels
INK, GROUND = (26, 82, 118), (234, 242, 248)  # red, green, blue
WIDTH = 0.045  # of a line, as a share of the size
Stroke = tuple[tuple[float, float], tuple[float, float]]  # a line from one point to the other, in 0..1, y upwards
Ring = tuple[float, float, float]  # a circle: centre and radius

DEVICE: tuple[list[Stroke], list[Ring]] = (
    [((0.15, 0.3), (0.85, 0.3)), ((0.15, 0.3), (0.1, 0.4)), ((0.85, 0.3), (0.9, 0.4)), ((0.5, 0.3), (0.5, 0.1)),
     ((0.35, 0.62), (0.18, 0.36)), ((0.65, 0.62), (0.82, 0.36)), ((0.35, 0.62), (0.65, 0.62))],
    [(0.5, 0.78, 0.12)],
)  # fmt: skip
VEHICLE: tuple[list[Stroke], list[Ring]] = (
    [((0.24, 0.28), (0.52, 0.32)), ((0.52, 0.32), (0.7, 0.6)), ((0.24, 0.28), (0.42, 0.58)), ((0.42, 0.58), (0.7, 0.6)),
     ((0.78, 0.28), (0.66, 0.72)), ((0.66, 0.72), (0.56, 0.74))],
    [(0.24, 0.28, 0.17), (0.78, 0.28, 0.17)],
)  # fmt: skip
BLOCK: tuple[list[Stroke], list[Ring]] = (
    [((0.1, 0.2), (0.1, 0.8)), ((0.1, 0.5), (0.2, 0.5)), ((0.2, 0.5), (0.26, 0.62)), ((0.26, 0.62), (0.34, 0.38)),
     ((0.34, 0.38), (0.42, 0.62)), ((0.42, 0.62), (0.48, 0.5)), ((0.48, 0.5), (0.56, 0.5)), ((0.56, 0.3), (0.56, 0.7)),
     ((0.56, 0.7), (0.9, 0.7)), ((0.9, 0.7), (0.9, 0.3)), ((0.9, 0.3), (0.56, 0.3))],
    [],
)  # fmt: skip


def drawing(interface: Interface) -> tuple[list[Stroke], list[Ring]]:
    """The lines and circles for a component."""
    flows = {v.role for v in interface.variables if v.row.flow}
    return DEVICE if "output" in flows else VEHICLE if "input" in flows else BLOCK


def png(interface: Interface) -> bytes:
    """The icon as a PNG file, the same for the same component."""
    strokes, rings = drawing(interface)
    x, y = np.meshgrid((np.arange(SIZE) + 0.5) / SIZE, 1 - (np.arange(SIZE) + 0.5) / SIZE)
    distances = [_to_stroke(x, y, *stroke) for stroke in strokes]
    distances += [np.abs(np.hypot(x - cx, y - cy) - radius) for cx, cy, radius in rings]
    cover = np.clip((WIDTH / 2 - np.min(distances, axis=0)) * SIZE + 0.5, 0.0, 1.0)[..., None]
    pixels = np.rint(np.array(GROUND) * (1 - cover) + np.array(INK) * cover).astype(np.uint8)
    rows = b"".join(b"\0" + row.tobytes() for row in pixels)
    header = struct.pack(">IIBBBBB", SIZE, SIZE, 8, 2, 0, 0, 0)
    parts = ((b"IHDR", header), (b"IDAT", zlib.compress(rows, 9)), (b"IEND", b""))
    return b"\x89PNG\r\n\x1a\n" + b"".join(_chunk(*part) for part in parts)


def svg(interface: Interface) -> bytes:
    """The icon as an SVG file."""
    strokes, rings = drawing(interface)
    lines = [f'<line x1="{a[0]:g}" y1="{1 - a[1]:g}" x2="{b[0]:g}" y2="{1 - b[1]:g}"/>' for a, b in strokes]
    circles = [f'<circle cx="{cx:g}" cy="{1 - cy:g}" r="{radius:g}"/>' for cx, cy, radius in rings]
    return ('<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 1 1">'
            f'<rect width="1" height="1" fill="{_hex(GROUND)}"/>'
            f'<g fill="none" stroke="{_hex(INK)}" stroke-width="{WIDTH}" stroke-linecap="round">'
            f"{''.join(lines + circles)}</g></svg>\n").encode()  # fmt: skip


def _to_stroke(x: np.ndarray, y: np.ndarray, a: tuple[float, float], b: tuple[float, float]) -> np.ndarray:
    """The distance of points from a line between two ends."""
    along = np.subtract(b, a)
    share = np.clip(((x - a[0]) * along[0] + (y - a[1]) * along[1]) / (along @ along), 0.0, 1.0)
    return np.hypot(x - a[0] - share * along[0], y - a[1] - share * along[1])


def _chunk(kind: bytes, data: bytes) -> bytes:
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


def _hex(colour: Sequence[int]) -> str:
    return "#" + "".join(f"{c:02x}" for c in colour)
