"""A beating object whose value at every place and phase is known in closed form.

No flip, transposition, order of slices, order or direction of phases maps it onto itself: three
ramps of different slope, three blobs of different size, and a pulse that is not even in time.
"""
import numpy as np

RR_MS = 843.7  # no round number, no whole number of milliseconds


def turned(a=0.5, b=-0.35, c=0.8):
    """Columns: directions of growing column, row and slice index in LPS; determinant +1."""
    rx = np.array([[1, 0, 0], [0, np.cos(a), -np.sin(a)], [0, np.sin(a), np.cos(a)]])
    ry = np.array([[np.cos(b), 0, np.sin(b)], [0, 1, 0], [-np.sin(b), 0, np.cos(b)]])
    rz = np.array([[np.cos(c), -np.sin(c), 0], [np.sin(c), np.cos(c), 0], [0, 0, 1]])
    return rz @ ry @ rx


AXIAL = np.eye(3)
CORONAL = np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]])
SAGITTAL = np.array([[0.0, 0, -1], [1, 0, 0], [0, -1, 0]])


class BeatingObject:
    """The object, and the lattice on which it is written: columns x rows x slices, phases."""

    def __init__(self, size=(36, 28, 5), step=(2.1, 1.7, 7.3), phases=10, turn=None,
                 origin=(-97.31, 41.73, -112.97), rr_ms=RR_MS, offset=0.0, gain=1.0):
        self.size, self.step, self.phases, self.rr_ms = size, np.array(step, float), phases, rr_ms
        self.turn = turned() if turn is None else np.array(turn, float)
        self.offset, self.gain = offset, gain
        self.lps = np.eye(4)
        self.lps[:3, :3] = self.turn * self.step
        self.lps[:3, 3] = origin
        self.extent = np.maximum(self.step * (np.array(size) - 1), 20.0)
        self.centre = self.place(0.5 * (np.array(size) - 1))

    def place(self, index):
        """LPS [mm] of (column, row, slice)."""
        return np.asarray(index, float) @ self.lps[:3, :3].T + self.lps[:3, 3]

    def value(self, lps, phase):
        """The truth at places [mm] (..., 3) and a phase in 0..1 of the R-R interval."""
        at = (np.asarray(lps, float) - self.centre) @ (self.turn / (0.5 * self.extent))
        x, y, z = at[..., 0], at[..., 1], at[..., 2]
        out = 900.0 + 61.0 * x - 83.0 * y + 107.0 * z
        for centre, width, height, lag in (((0.4, -0.3, 0.5), 0.45, 900.0, 0.0),
                                           ((-0.5, -0.4, -0.2), 0.35, 700.0, 0.11),
                                           ((-0.1, 0.55, -0.6), 0.4, 500.0, 0.27)):
            angle = 2 * np.pi * (phase - lag)
            pulse = 1 + 0.3 * np.cos(angle - 0.7) + 0.1 * np.cos(2 * angle + 1.1)
            far2 = (x - centre[0]) ** 2 + (y - centre[1]) ** 2 + (z - centre[2]) ** 2
            out = out + height * pulse * np.exp(-far2 / (2 * width ** 2))
        return self.gain * out + self.offset

    def image(self, k, phase):
        """Rows x columns of slice k."""
        i, j = np.meshgrid(np.arange(self.size[0]), np.arange(self.size[1]))
        return self.value(self.place(np.stack([i, j, np.full_like(i, k)], axis=-1)), phase)

    def array(self):
        """values[column, row, slice, phase]."""
        index = np.stack(np.meshgrid(*map(np.arange, self.size), indexing="ij"), axis=-1)
        places = self.place(index)
        return np.stack([self.value(places, p / self.phases) for p in range(self.phases)], axis=-1)

    def reordered(self, axes=(0, 1, 2), flips=(False, False, False)):
        """The same voxels in another order, and the map of that order to LPS."""
        data, affine = self.array(), self.lps.copy()
        for axis, flip in enumerate(flips):
            if flip:
                data = np.flip(data, axis)
                affine[:3, 3] += affine[:3, axis] * (self.size[axis] - 1)
                affine[:3, axis] *= -1
        affine[:3, :3] = affine[:3, list(axes)]
        return np.transpose(data, [*axes, 3]), affine

    def times_s(self):
        return [p * self.rr_ms / self.phases / 1e3 for p in range(self.phases)]


def expect_places(cine, truth):
    """The exam's voxels lie where the object's do, one on one, to 0.01 mm."""
    index_from_lps = np.linalg.inv(truth.lps)
    corners = cine.corners(cine.lps)
    index = corners @ index_from_lps[:3, :3].T + index_from_lps[:3, 3]
    off = np.linalg.norm(truth.place(np.round(index)) - corners, axis=1).max()
    assert off < 0.01, f"a corner of the grid lies {off:.4f} mm beside a voxel centre"
    top = np.array(truth.size) - 1
    whole = np.round(index)
    assert (whole.min(axis=0) == 0).all() and (whole.max(axis=0) == top).all(), (
        f"the exam spans voxels {whole.min(axis=0)}..{whole.max(axis=0)} of 0..{top}")
    assert np.prod(cine.size) == np.prod(truth.size), (cine.size, truth.size)


def expect_object(exam, truth, error=0.51, rr_error_s=0.6e-3, times=True, phases=None):
    """@param error how far a value may be off: half a stored step and the arithmetic."""
    cine = exam.stack
    expect_places(cine, truth)
    phases = phases or truth.phases
    assert cine.phases == phases, f"{cine.phases} phases of {phases}"
    places = cine.places()
    for p in range(phases):
        off = np.abs(cine.values[..., p] - truth.value(places, p / phases))
        at = np.unravel_index(off.argmax(), off.shape)
        assert off.max() <= error, (
            f"phase {p}, voxel {at}: {cine.values[(*at, p)]:.3f} is off by {off.max():.3f}\n" +
            "\n".join(exam.decisions))
    # DICOM's nominal interval is whole milliseconds.
    assert abs(cine.rr_s - truth.rr_ms / 1e3) < rr_error_s, f"R-R {cine.rr_s} of {truth.rr_ms} ms"
    if times:
        assert len(cine.times_s) == phases, (len(cine.times_s), phases)
        miss = np.abs(np.array(cine.times_s) - truth.times_s()).max()
        assert miss < rr_error_s, f"times {cine.times_s} of {truth.times_s()}"


def expect_tellable(truth):
    """Guards the tests: a flip, a transposition or another order of phases is seen."""
    data = truth.array()
    for axis in range(4):
        assert np.abs(np.flip(data, axis) - data).max() > 50
        for shift in range(1, data.shape[axis]):
            assert np.abs(np.roll(data, shift, axis) - data).max() > 20
    turned_in_time = data[..., (-np.arange(truth.phases)) % truth.phases]
    assert np.abs(turned_in_time - data).max() > 20
