"""An MPU6050 at the level of its registers, on a bus with the interface of `smbus2.SMBus`."""

import struct
from collections import deque
from dataclasses import dataclass, field

FIFO_SIZE = 1024

BYTE_TIME = 9 / 400_000
"""s on a bus of 400 kHz."""


@dataclass
class FakeMpu6050:
    """The chip and the host's clock; the n-th sample since the reset reads n, -n, 2048, 0, n, 0, 0.

    Attributes
    ----------
    rate : float
        Seconds of the host in a second of the chip.
    failures : deque of float
        Times from which on one transfer fails.
    """

    rate: float = 1.0
    who_am_i: int = 0x68
    address: int = 0x68
    deaf_registers: frozenset[int] = frozenset()
    failures: deque[float] = field(default_factory=deque)
    now: float = 100.0
    closed: bool = False
    taken: int = 0
    dropped: int = 0

    def __post_init__(self) -> None:
        """Switch it on."""
        self._power_on()

    def _power_on(self) -> None:
        self.registers = bytearray(128)
        self.registers[0x6B] = 0x40
        self.registers[0x75] = self.who_am_i
        self.fifo: deque[int] = deque()
        self.next_sample = self.now

    # The host's clock

    def clock(self) -> float:
        return self.now

    def sleep(self, seconds: float) -> None:
        self._pass(seconds)

    def _pass(self, seconds: float) -> None:
        self.now += seconds
        interval = (
            self.rate * (1 + self.registers[0x19]) / (1000 if self.registers[0x1A] & 7 else 8000)
        )
        awake = self.registers[0x6B] & 0x40 == 0
        if not awake:
            self.next_sample = self.now + interval
        while awake and self.next_sample <= self.now:
            self.next_sample += interval
            self._sample()

    def _sample(self) -> None:
        self.taken += 1
        n = self.taken % 2**15
        if self.registers[0x6A] & 0x40:
            # 0xF8: all sensors, in the order of their registers.
            assert self.registers[0x23] == 0xF8
            self.fifo.extend(struct.pack(">7h", n, -n, 2048, 0, n, 0, 0))
        while len(self.fifo) > FIFO_SIZE:
            self.fifo.popleft()
            self.registers[0x3A] |= 0x10

    # smbus2.SMBus

    def read_byte_data(self, i2c_addr: int, register: int) -> int:
        return self.read_i2c_block_data(i2c_addr, register, 1)[0]

    def read_i2c_block_data(self, i2c_addr: int, register: int, length: int) -> list[int]:
        assert 1 <= length <= 32
        self._transfer(i2c_addr, length + 3)
        if register == 0x74:
            return [self.fifo.popleft() if self.fifo else 0xFF for _ in range(length)]
        if register == 0x72:
            return list(struct.pack(">H", len(self.fifo)))[:length]
        values = list(self.registers[register : register + length])
        if register == 0x3A:
            self.registers[0x3A] = 0
        return values

    def write_byte_data(self, i2c_addr: int, register: int, value: int) -> None:
        self._transfer(i2c_addr, 3)
        if register == 0x6B and value & 0x80:
            self._power_on()
        elif register == 0x6A and value & 0x04:
            assert not value & 0x40, "the FIFO is to be stopped while it is emptied"
            self.fifo.clear()
            self.registers[0x6A] = value & ~0x04
        elif register not in self.deaf_registers:
            self.registers[register] = value

    def close(self) -> None:
        self.closed = True

    def _transfer(self, address: int, length: int) -> None:
        self._pass(length * BYTE_TIME)
        if address != self.address or (
            self.failures and self.now >= self.failures[0] and self.failures.popleft()
        ):
            raise OSError(121, "Remote I/O error")
