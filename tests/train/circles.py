#!/usr/bin/python3
"""Writes records as heart_draws does, of bright discs in dark rings: a stand-in for tests.

circles.py --first SEED --count N --stream
"""
import argparse
import sys

import numpy

SIZE = 128
ROW, COLUMN = numpy.mgrid[:SIZE, :SIZE].astype(numpy.float32)


def record(seed: int) -> numpy.ndarray:
    """6 x 128 x 128 bytes: five images and the label; a heart of an LV in its muscle beside an RV."""
    random = numpy.random.default_rng(seed)
    row, column = random.uniform(40, 88, 2)
    radius, wall, turn = random.uniform(6, 14), random.uniform(3, 8), random.uniform(0, 6.283)
    labels = numpy.zeros((SIZE, SIZE), numpy.uint8)

    def disc(r: float, c: float, size: float, name: int) -> None:
        labels[(ROW - r) ** 2 + (COLUMN - c) ** 2 < size * size] = name

    away = radius + wall
    disc(row + away * numpy.sin(turn), column + away * numpy.cos(turn), radius * 1.3, 1)
    disc(row, column, radius + wall, 2)
    disc(row, column, radius, 3)
    labels[:2] = 255
    shade = numpy.array([0.4, 0.8, 0.2, 0.9] + [0.4] * 252)[labels]
    image = shade + random.normal(0, 0.05, (4, SIZE, SIZE))
    if seed % 3 == 0:
        image[1] = 0  # below is not known
    moving = numpy.isin(labels, (1, 2, 3)) * 0.3
    planes = numpy.concatenate((image, moving[None])).clip(0, 1.2) * 212
    return numpy.concatenate((planes.round().astype(numpy.uint8), labels[None]))


parser = argparse.ArgumentParser()
parser.add_argument("--first", type=int, required=True)
parser.add_argument("--count", type=int, required=True)
parser.add_argument("--stream", action="store_true", required=True)
wanted = parser.parse_args()
try:
    for n in range(wanted.count):
        sys.stdout.buffer.write(record(wanted.first + n).tobytes())
    sys.stdout.buffer.flush()
except BrokenPipeError:
    sys.exit(0)
