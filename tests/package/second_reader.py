"""second_reader.py BEATLAS_PLAY MAP_VALUES PACKAGE...

docs/package_format.md is enough to write another reader: this one, of fields and surface maps, was
written from it and shares no code with beatlas. Its distances agree with those of `beatlas-play probe`,
its maps with what our reader gives."""
import csv
import ctypes
import ctypes.util
import io
import json
import pathlib
import struct
import subprocess
import sys
import tempfile
import zipfile

import numpy

BAND_ENDS = (0, 1, 4, 10, 20, 35, 56, 84, 120, 165, 220, 300, 400, 512)
FIRST_PAIRED_BAND = 6


def unpacked(frame):
    """One zstd frame."""
    library = ctypes.CDLL(ctypes.util.find_library("zstd"))
    library.ZSTD_getFrameContentSize.restype = ctypes.c_ulonglong
    library.ZSTD_decompress.restype = ctypes.c_size_t
    size = library.ZSTD_getFrameContentSize(frame, ctypes.c_size_t(len(frame)))
    out = ctypes.create_string_buffer(size)
    done = library.ZSTD_decompress(out, ctypes.c_size_t(size), frame, ctypes.c_size_t(len(frame)))
    assert done == size, "the frame is damaged"
    return out.raw


def unzigzag(code):
    return (code >> 1) ^ -(code & 1)


def cycle_modes(phases):
    p = numpy.arange(phases)
    rows = [numpy.full(phases, 1 / numpy.sqrt(phases))]
    for mode in range(1, phases):
        turn = 2 * numpy.pi * ((mode + 1) // 2) * p / phases
        row = numpy.cos(turn) if mode % 2 else numpy.sin(turn)
        rows.append(row / numpy.linalg.norm(row))
    return numpy.array(rows)


class Field:
    def __init__(self, entry):
        data = unpacked(entry)
        assert data[:8] == b"BEATFLD\0"
        version, self.phases, *self.blocks, leaves = struct.unpack_from("<IIIIII", data, 8)
        assert version == 2
        self.origin = numpy.array(struct.unpack_from("<3d", data, 32))
        self.voxel, self.step, self.inner, self.outer, quantum, apart_count = struct.unpack_from(
            "<5dI", data, 56)
        count = int(numpy.prod(self.blocks))
        self.state = numpy.frombuffer(data, "u1", count, 100)
        at = 100 + count

        def take(kind, many):
            nonlocal at
            out = numpy.frombuffer(data, kind, many, at)
            at += out.nbytes
            return out

        grade = take("u1", leaves)
        length = take("<u2", leaves * self.phases).reshape(leaves, self.phases)
        apart_of = take("<u4", leaves)
        bands = []
        for b, (begin, end) in enumerate(zip(BAND_ENDS, BAND_ENDS[1:])):
            terms = numpy.clip(length.astype(int), begin, end) - begin
            bands.append(take("u1", int((terms if b < FIRST_PAIRED_BAND else (terms + 1) // 2).sum())))
        apart = take("<u4", apart_count)
        assert at == len(data) and apart_of.sum() == apart_count
        self.leaves = self.coefficients(grade, length, bands, apart, quantum)

    def coefficients(self, grade, length, bands, apart, quantum):
        """[leaf][z][y][x][phase], in mm."""
        k = numpy.arange(8)
        order = sorted(range(512), key=lambda n: (
            n % 8 + n // 8 % 8 + n // 64, (n % 8) ** 2 + (n // 8 % 8) ** 2 + (n // 64) ** 2, n))
        kept = (2 + numpy.cos(numpy.pi * k / 8)) / 3
        frequency = (numpy.arange(self.phases) + 1) // 2
        kept_in_time = (2 + numpy.cos(2 * numpy.pi * frequency / self.phases)) / 3
        scale = 1 / (kept[:, None, None] * kept[None, :, None] * kept[None, None, :])
        cosines = 0.5 * numpy.cos(numpy.pi * k[:, None] * (2 * k[None, :] + 1) / 16)
        cosines[0] = numpy.sqrt(1 / 8)
        modes = cycle_modes(self.phases)
        # Codes are read band by band; those apart, leaf by leaf.
        terms = numpy.zeros((len(grade), self.phases, 512), int)
        for b, (begin, end) in enumerate(zip(BAND_ENDS, BAND_ENDS[1:])):
            at = 0
            for leaf in range(len(grade)):
                for mode in range(self.phases):
                    many = min(max(int(length[leaf, mode]), begin), end) - begin
                    if b < FIRST_PAIRED_BAND:
                        codes = bands[b][at:at + many].astype(int)
                        at += many
                        codes[codes == 255] = -1
                    else:
                        pairs = bands[b][at:at + (many + 1) // 2]
                        at += (many + 1) // 2
                        codes = numpy.stack([pairs >> 4, pairs & 15], 1).ravel()[:many].astype(int)
                        codes[codes == 15] = -1
                    terms[leaf, mode, begin:begin + many] = codes
            assert at == len(bands[b])
        terms[terms == -1] = apart
        terms = unzigzag(terms).astype(float)
        out = numpy.empty((len(grade), 8, 8, 8, self.phases))
        for leaf in range(len(grade)):
            placed = numpy.empty((self.phases, 512))
            placed[:, order] = terms[leaf]
            placed = placed.reshape(self.phases, 8, 8, 8) * scale  # [mode][l][j][i]
            placed *= quantum / 2.0 ** grade[leaf] / kept_in_time[:, None, None, None]
            out[leaf] = numpy.einsum("mlji,lz,jy,ix,mp->zyxp", placed, cosines, cosines, cosines,
                                     modes, optimize=True)
        return out

    def coefficient(self, index):
        """Of a sample, in every phase."""
        index = numpy.array(index)
        block = index // 8
        beyond = numpy.full(self.phases, self.outer)
        if (index < 0).any() or (block >= self.blocks).any():
            return beyond
        at = block[0] + self.blocks[0] * (block[1] + self.blocks[1] * block[2])
        if self.state[at] != 2:
            return beyond if self.state[at] == 0 else numpy.full(self.phases, -self.inner)
        leaf = int((self.state[:at] == 2).sum())
        x, y, z = index % 8
        return self.leaves[leaf, z, y, x]

    def distance(self, mm, share_of_beat):
        def weights(u):
            return numpy.array([(1 - u) ** 3, 3 * u ** 3 - 6 * u ** 2 + 4,
                                -3 * u ** 3 + 3 * u ** 2 + 3 * u + 1, u ** 3]) / 6

        where = (numpy.array(mm) - self.origin) / self.voxel
        first = numpy.floor(where).astype(int)
        space = [weights(u) for u in where - first]
        n = share_of_beat * self.phases
        phase = int(numpy.floor(n))
        time = weights(n - phase)
        which = [(phase + p - 1) % self.phases for p in range(4)]
        total = 0.0
        for c in range(4):
            for b in range(4):
                for a in range(4):
                    value = self.coefficient(first + (a - 1, b - 1, c - 1))[which] @ time
                    total += space[0][a] * space[1][b] * space[2][c] * value
        return min(max(total, -self.inner), self.outer)


def read_map(entry):
    """[vertex][long axis, angle, segment, thickness of each phase]."""
    data = unpacked(entry)
    assert data[:8] == b"BEATMAP\0"
    version, vertices, phases = struct.unpack_from("<III", data, 8)
    assert version == 1
    step, = struct.unpack_from("<d", data, 20)
    segment = numpy.frombuffer(data, "u1", vertices, 28)
    at = 28 + vertices

    def take(many):
        nonlocal at
        planes = numpy.frombuffer(data, "u1", 2 * many, at).astype(int)
        at += 2 * many
        return unzigzag(planes[:many] + 256 * planes[many:])

    place = numpy.cumsum(take(vertices)) % 65536
    angle = numpy.cumsum(take(vertices)) % 1024
    # The difference of differences, summed along both.
    count = take(phases * vertices).reshape(phases, vertices).cumsum(0).cumsum(1) % 65536
    assert at == len(data)
    return numpy.column_stack([place / 1024, angle * 2 * numpy.pi / 1024, segment, step * count.T])


def check_map(map_values, package, structure, level, entry):
    read = read_map(entry)
    said = subprocess.run([map_values, package, structure, str(level)], check=True, capture_output=True, text=True).stdout
    theirs = numpy.array([[float(value) for value in line.split(",")] for line in said.split()])
    assert theirs.shape == read.shape
    assert set(read[:, 2]) == {0} if structure == "rv_blood" else len(set(read[:, 2])) > 5
    worst = abs(read - theirs).max()
    print(f"{package}: map of {len(read)} vertices of {structure}, at most {worst:.1e} apart")
    assert worst < 1e-5, worst  # of floats


def main():
    play, map_values = sys.argv[1:3]
    maps = 0
    for package in sys.argv[3:]:
        with zipfile.ZipFile(package) as archive:
            manifest = json.loads(archive.read("atlas.json"))
            field = Field(archive.read("fields/heart.field.zst"))
            for item in manifest["items"]:
                if item["kind"] == "surface_map":
                    check_map(map_values, package, item["structure"], item.get("level", 0), archive.read(item["path"]))
                    maps += 1
        rr = manifest["rr_interval_s"]
        random = numpy.random.default_rng(5)
        high = field.origin + field.voxel * 8 * numpy.array(field.blocks)
        rows = [(random.uniform(0, rr), *random.uniform(field.origin, high)) for _ in range(400)]
        with tempfile.TemporaryDirectory() as folder:
            points = pathlib.Path(folder) / "points.csv"
            points.write_text("t_s,x_mm,y_mm,z_mm\n" + "".join(
                ",".join(repr(float(v)) for v in row) + "\n" for row in rows))
            said = subprocess.run([play, "probe", package, "--points", points], check=True,
                                  capture_output=True, text=True).stdout
        probed = [float(row["distance_mm"]) for row in csv.DictReader(io.StringIO(said))]
        read = [field.distance(row[1:], row[0] / rr) for row in rows]
        near = [n for n in range(len(rows)) if -field.inner < read[n] < field.outer]
        assert len(near) > 40, f"{package}: {len(near)} of the points tell anything"
        worst = max(abs(read[n] - probed[n]) for n in range(len(rows)))
        print(f"{package}: {len(near)} distances, at most {worst:.5f} mm apart")
        # The runtime rounds coefficients to counts.
        assert worst <= 0.51 * field.step, worst
    assert maps == 9, maps  # of v4, of v5 in two levels, and of v6 and v7 in two and of the RV

main()
