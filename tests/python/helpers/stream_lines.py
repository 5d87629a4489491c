"""Lines of the sketch `mpu6050_stream`, independent of the decoder, and a simulated board."""

import struct
from collections.abc import Iterable
from functools import lru_cache

SETTINGS = bytes((4, 2, 3 << 3, 3 << 3))
"""200 Hz, low-pass 2, 2000 deg/s, 16 g."""

AT_REST = (0, 0, 2048, -2160, 10, -20, 30)
"""Counts at 16 g and 2000 deg/s with z up, at 30.2 degrees Celsius."""

Counts = tuple[int, ...]


@lru_cache(4096)
def crc16(text: bytes) -> int:
    """CRC-16/IBM-3740, bit by bit."""
    crc = 0xFFFF
    for byte in text:
        crc ^= byte << 8
        for _ in range(8):
            crc = (crc << 1 ^ 0x1021 if crc & 0x8000 else crc << 1) & 0xFFFF
    return crc


def close(text: str) -> bytes:
    return f"{text}{crc16(text.encode()):04X}\n".encode()


def sample_line(stamp: int, number: int, counts: Iterable[int] = AT_REST) -> bytes:
    registers = struct.pack(">7h", *counts)
    return close(f"S{stamp % 2**32:08X}{number % 2**16:04X}{registers.hex().upper()}")


def header_line(
    settings: bytes = SETTINGS, device: int = 1, chip: int = 0x68, protocol: int = 1
) -> bytes:
    return close(f"H{protocol:02X}{device:04X}{chip:02X}{settings.hex().upper()}")


def fault_line(code: int, detail: int = 0) -> bytes:
    return close(f"X{code:02X}{detail:02X}")


def stream(
    samples: Iterable[Counts], stamp: int = 0, number: int = 0, interval: int = 5000
) -> list[bytes]:
    """Write a header and the lines of samples at 200 Hz."""
    lines = [
        sample_line(stamp + k * interval, number + k, counts) for k, counts in enumerate(samples)
    ]
    return [header_line(), *lines]
