"""Draws the icon as PNG; the shapes are those of package/icon.svg."""

from __future__ import annotations

import math
import struct
import zlib

Colour = tuple[int, int, int]
# (x1, y1, x2, y2, width, colour): a line with round ends; a disc has both ends in one place.
SHAPES: list[tuple[float, float, float, float, float, Colour]] = [
    (50, 60, 50, 160, 34, (0xC9, 0xD3, 0xDA)),
    (50, 62, 108, 52, 13, (0x60, 0x7D, 0x8B)),
    (108, 52, 122, 118, 18, (0x00, 0x69, 0x5C)),
    (122, 118, 172, 92, 15, (0x26, 0xA6, 0x9A)),
    (108, 52, 108, 52, 34, (0xEF, 0x6C, 0x00)),
    (108, 52, 108, 52, 14, (0xFF, 0xFF, 0xFF)),
    (122, 118, 122, 118, 22, (0xEF, 0x6C, 0x00)),
    (172, 92, 172, 92, 18, (0xEF, 0x6C, 0x00)),
    (50, 28, 50, 28, 38, (0xC9, 0xD3, 0xDA)),
]


def distance(x: float, y: float, shape: tuple[float, float, float, float, float, Colour]) -> float:
    """Distance of a point to the edge of a shape, negative inside, in pixels."""
    x1, y1, x2, y2, width, _ = shape
    length2 = (x2 - x1) ** 2 + (y2 - y1) ** 2
    along = 0.0 if length2 == 0 else min(1.0, max(0.0, ((x - x1) * (x2 - x1) + (y - y1) * (y2 - y1)) / length2))
    return math.hypot(x - x1 - along * (x2 - x1), y - y1 - along * (y2 - y1)) - width / 2


def pixel(x: float, y: float) -> bytes:
    """RGBA of one pixel, edges smoothed over one pixel."""
    colour: tuple[float, ...] = (255.0, 255.0, 255.0)
    alpha = 0.0
    for shape in SHAPES:
        cover = min(1.0, max(0.0, 0.5 - distance(x, y, shape)))
        if cover > 0:
            total = cover + alpha * (1 - cover)
            colour = tuple((s * cover + c * alpha * (1 - cover)) / total for s, c in zip(shape[5], colour, strict=True))
            alpha = total
    return bytes(round(c) for c in (*colour, 255 * alpha))


def chunk(kind: bytes, data: bytes) -> bytes:
    """One PNG chunk."""
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


def icon_png(size: int = 200) -> bytes:
    """The icon, size x size pixels, transparent ground."""
    scale = 200 / size
    rows = b"".join(
        b"\0" + b"".join(pixel((x + 0.5) * scale, (y + 0.5) * scale) for x in range(size)) for y in range(size)
    )
    header = struct.pack(">IIBBBBB", size, size, 8, 6, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(rows, 9)) + chunk(b"IEND", b"")
