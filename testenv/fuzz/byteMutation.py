# SPDX-License-Identifier: Apache-2.0
"""Mutations of files of bytes: flipped, cut, repeated, moved; numbers of 1, 2, 4 and 8 bytes set to extremes."""

_EXTREMES = [0, 1, 2, 0x7F, 0x80, 0xFF, 0x7FFF, 0x8000, 0xFFFF, 0x10000, 0x7FFFFFFF, 0x80000000, 0xFFFFFFFF, 1 << 32, (1 << 63) - 1,
             1 << 63, (1 << 64) - 1]


def _Place(data, rng):
    """A place in the file, half of the time in its header."""
    return rng.randrange(min(len(data), 256) if rng.random() < 0.5 else len(data))


def _Flip(data, rng):
    for _ in range(rng.choice([1, 1, 4, 50])):
        data[_Place(data, rng)] ^= 1 << rng.randrange(8)


def _Random(data, rng):
    for _ in range(rng.choice([1, 1, 4, 50])):
        data[_Place(data, rng)] = rng.randrange(256)


def _Extreme(data, rng):
    size = rng.choice([1, 2, 4, 8])
    value = rng.choice(_EXTREMES) & ((1 << 8 * size) - 1)
    at = _Place(data, rng)
    data[at: at + size] = value.to_bytes(size, rng.choice(["little", "big"]))[: len(data) - at]


def _Cut(data, rng):
    del data[rng.randrange(len(data)):]


def _Remove(data, rng):
    at = _Place(data, rng)
    del data[at: at + rng.choice([1, 4, 64, 1000])]


def _Repeat(data, rng):
    at, size = _Place(data, rng), rng.choice([1, 4, 64, 1000])
    data[at:at] = data[at: at + size]


def _Zero(data, rng):
    at, size = _Place(data, rng), rng.choice([4, 64, 4096])
    data[at: at + size] = bytes(len(data[at: at + size]))


def Mutated(data: bytes, rng) -> bytes:
    """The bytes after one to four mutations."""
    data = bytearray(data)
    for _ in range(rng.choice([1, 1, 2, 4])):
        if data:
            rng.choice([_Flip, _Flip, _Random, _Extreme, _Extreme, _Cut, _Remove, _Repeat, _Zero])(data, rng)
    return bytes(data)
