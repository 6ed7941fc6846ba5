"""Drawn slices: read from a program while the trainer runs, kept in a ring, varied as they are used.

A record is 6 planes of 128 x 128 bytes: frame, below, above, mean and deviation (byte / 212) and the
label (0..7 as model.OUTPUTS, 255 unknown). `below` and `above` of zeros are not known.
"""
import pathlib
import subprocess
import threading
from typing import IO

import numpy
import torch

SIZE = 128
CROP = 96        # pixels along an edge of what is learned from, a multiple of 16
ABOUT_HEART = 0.65  # of the parts; the others show what lies around it and is none
PLANES = 6
RECORD_BYTES = PLANES * SIZE * SIZE
BYTE_OF_ONE = 212.0   # 1.2, the largest value, lies at 254
LARGEST = 1.2
UNKNOWN = 255
FRAME, BELOW, ABOVE, MEAN, DEVIATION, LABEL = range(PLANES)
HELD_OUT_FIRST = 2_000_000_000  # seeds from here on are never trained on


class DrawsEnded(RuntimeError):
    """The program that draws stopped before it had written what was asked of it."""


def open_draws(program: pathlib.Path, first: int, count: int, niceness: int = 10) -> subprocess.Popen:
    """The program at work; it yields to the trainer, which is the slower of the two."""
    words = ["nice", "-n", str(niceness), str(program.resolve()), "--first", str(first),
             "--count", str(count), "--stream"]
    return subprocess.Popen(words, stdout=subprocess.PIPE, stdin=subprocess.DEVNULL)



def read_record(stream: IO[bytes], place: numpy.ndarray) -> bool:
    """Fills `place` (6 x 128 x 128 bytes); false where the stream ends."""
    view = memoryview(place).cast("B")
    done = 0
    while done < RECORD_BYTES:
        got = stream.readinto(view[done:])
        if not got:
            return False
        done += got
    return True


def read_all(program: pathlib.Path, first: int, count: int) -> numpy.ndarray:
    """`count` records, as bytes of shape count x 6 x 128 x 128.  @throws DrawsEnded"""
    records = numpy.empty((count, PLANES, SIZE, SIZE), numpy.uint8)
    with open_draws(program, first, count, niceness=0) as drawing:
        for n in range(count):
            if not read_record(drawing.stdout, records[n]):
                raise DrawsEnded(f"{program} wrote {n} of {count} records; run it by hand to see why")
    return records


class Ring:
    """Records in a ring: a thread writes new ones over the oldest, the trainer takes any of those there.

    A record is used `reuse` times on average before it is written over: the writer may be ahead of the
    trainer by as much, so a program that is fast waits, and where it is slow the trainer goes on with
    what there is (`reused` tells how often). Which records meet depends on the speed of the program, so
    a run that is repeated is alike, but not the same to the bit.
    """

    def __init__(self, program: pathlib.Path, first: int, capacity: int, reuse: float) -> None:
        if capacity < 1 or reuse <= 0:
            raise ValueError("the pool needs room for a record, and --reuse must be positive")
        self.capacity, self.reuse = capacity, reuse
        self.records = numpy.empty((capacity, PLANES, SIZE, SIZE), numpy.uint8)
        self.written = 0  # records since the start, those written over included
        self.used = 0     # records that the trainer has taken since the start
        self.failure: Exception | None = None
        self._program, self._first = program, first
        self._change = threading.Condition()
        self._stopping = False
        # More than any run uses; the program is ended when the ring is closed.
        self._process = open_draws(program, first, HELD_OUT_FIRST - first)
        self._thread = threading.Thread(target=self._fill, name="draws", daemon=True)
        self._thread.start()

    @property
    def reused(self) -> float:
        """How often a record was used so far, on average."""
        return self.used / max(1, self.written)

    def next_seed(self) -> int:
        """The first seed that was not written yet; a resumed run begins there."""
        return self._first + self.written

    def _fill(self) -> None:
        try:
            while not self._stopping:
                with self._change:
                    # The pool fills at once; then a place is free when enough was used for it.
                    self._change.wait_for(lambda: self._stopping or self.written < self.capacity or
                                          self.written - self.capacity < self.used / self.reuse)
                if self._stopping:
                    return
                # The trainer may read this very place while it is written over. A mixture of two records
                # in one of many thousand samples would do no harm, but a label of another image is
                # nothing to learn from, so the record arrives whole and is copied under the lock.
                record = numpy.empty((PLANES, SIZE, SIZE), numpy.uint8)
                if not read_record(self._process.stdout, record):
                    if self._stopping:
                        return
                    raise DrawsEnded(f"{self._program} ended after {self.written} records; run it by hand "
                                     f"with --first {self.next_seed()} --count 1 --stream to see why")
                with self._change:
                    self.records[self.written % self.capacity] = record
                    self.written += 1
                    self._change.notify_all()
        except Exception as error:  # noqa: BLE001 (it is raised again where the trainer takes records)
            with self._change:
                self.failure = error
                self._change.notify_all()

    def wait(self, count: int) -> None:
        """Until `count` records are there.  @throws what ended the program"""
        with self._change:
            self._change.wait_for(lambda: self.failure or self.written >= min(count, self.capacity))
            if self.failure:
                raise self.failure

    def take(self, count: int, random: numpy.random.Generator) -> numpy.ndarray:
        """`count` records picked at random (a copy).  @throws what ended the program"""
        self.wait(1)
        with self._change:
            picked = random.integers(0, min(self.written, self.capacity), count)
            self.used += count
            self._change.notify_all()
            return self.records[picked]

    def close(self) -> None:
        """Ends the program and the thread."""
        self._stopping = True
        with self._change:
            self._change.notify_all()
        self._process.terminate()
        self._thread.join(timeout=10)
        self._process.wait(timeout=10)
        self._process.stdout.close()


def planes(records: numpy.ndarray) -> tuple[torch.Tensor, torch.Tensor]:
    """Images (N x 5 x 128 x 128 float) and labels (N x 128 x 128 int64) of records."""
    images = torch.from_numpy(records[:, :LABEL]).float() / BYTE_OF_ONE
    return images, torch.from_numpy(records[:, LABEL]).long()


def _turned(records: numpy.ndarray, random: numpy.random.Generator) -> numpy.ndarray:
    """One of the eight flips and quarter turns of each, the label with its images."""
    out = numpy.empty_like(records)
    for n, record in enumerate(records):
        turns, flip = random.integers(4), random.integers(2)
        record = numpy.rot90(record, turns, axes=(1, 2))
        out[n] = record[:, :, ::-1] if flip else record
    return out


def _cropped(records: numpy.ndarray, random: numpy.random.Generator) -> numpy.ndarray:
    """Three quarters of each edge, mostly about a pixel of the heart.

    A network of convolutions is used on images of any size; in a part more of the pixels teach it
    something, and nearly twice as many parts are learned from in the same time.
    """
    out = numpy.empty((len(records), PLANES, CROP, CROP), numpy.uint8)
    for n, record in enumerate(records):
        heart = numpy.flatnonzero(record[LABEL])
        if len(heart) and random.random() < ABOUT_HEART:
            middle = divmod(int(heart[random.integers(len(heart))]), SIZE)
        else:
            middle = tuple(random.integers(SIZE, size=2))
        row, column = (int(numpy.clip(at - CROP // 2 + random.integers(-16, 17), 0, SIZE - CROP))
                       for at in middle)
        out[n] = record[:, row:row + CROP, column:column + CROP]
    return out


def vary(records: numpy.ndarray, random: numpy.random.Generator) -> tuple[torch.Tensor, torch.Tensor]:
    """Images and labels of records, each changed in ways that leave its label true.

    @param records N x 6 x 128 x 128 bytes; they are not changed
    @param random  everything is drawn from it, so that a seed gives the same
    """
    count = len(records)
    records = _cropped(_turned(records, random), random)
    swap = random.random(count) < 0.5
    records[swap, BELOW], records[swap, ABOVE] = records[swap, ABOVE], records[swap, BELOW]
    images, labels = planes(records)

    def drawn(low: float, high: float) -> torch.Tensor:
        return torch.from_numpy(random.uniform(low, high, (count, 1, 1, 1)).astype(numpy.float32))

    known = images.amax((2, 3), keepdim=True) > 0  # a plane of zeros stays one
    # v -> gain v^gamma + offset of what shows brightness; the deviation follows the gain and, at the
    # middle of the scale, the slope of the power, as a small difference of brightness would.
    gamma, gain, offset = drawn(0.75, 1.33), drawn(0.8, 1.15), drawn(-0.05, 0.05)
    bright = images[:, :DEVIATION].clamp_(min=1e-4).pow_(gamma).mul_(gain).add_(offset)
    moving = images[:, DEVIATION:].mul_(gain * gamma * 0.5 ** (gamma - 1))
    noise = drawn(0, 0.05) * (drawn(0, 1) < 0.7)
    if noise.any():
        grain = torch.from_numpy(random.standard_normal((count, DEVIATION, CROP, CROP), numpy.float32))
        grain[:, MEAN] *= 0.3  # a mean over many frames
        bright.add_(grain.mul_(noise))
    images = torch.cat((bright, moving), 1).clamp_(0, LARGEST).mul_(known)

    # What exams lack: motion (one frame), or neighbours (one slice; the ends of a stack).
    chance = random.random(count)
    single, still = chance < 0.05, chance < 0.20  # 5 % and another 15 %
    images[single, MEAN] = images[single, FRAME]
    images[still, DEVIATION] = 0
    alone = random.random(count) < 0.05
    images[alone | (random.random(count) < 0.10), BELOW] = 0
    images[alone | (random.random(count) < 0.10), ABOVE] = 0
    return images, labels
