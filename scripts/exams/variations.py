"""The same heart as another scanner, another protocol or a child would have given it.

A variation takes images [i, j, k, phase] and their affine (indices to mm) and gives both anew. What moves in space
is told by the affine, so that an expert's labels still lie where they did.
"""
import dataclasses

import numpy
from scipy import ndimage

SEED = 1


@dataclasses.dataclass
class Stack:
    images: numpy.ndarray  # [i, j, k, phase]
    affine: numpy.ndarray  # 4 x 4
    phases: list           # of the source, in their order
    larger: float = 1      # how many times as large as the expert's heart, along each axis

    @property
    def pixel_mm(self):
        return float(numpy.linalg.norm(self.affine[:3, 0]))

    def with_images(self, images):
        return dataclasses.replace(self, images=images.astype(numpy.float32))

    def each_image(self, change, shape=None):
        """`change` of every slice of every phase."""
        shape = shape or self.images.shape[:2]
        out = numpy.empty((*shape, *self.images.shape[2:]), numpy.float32)
        for k in range(out.shape[2]):
            for phase in range(out.shape[3]):
                out[..., k, phase] = change(self.images[..., k, phase])
        return out


def moved(affine, step):
    """The affine of new voxels, where `step` maps their indices to those of the old."""
    return affine @ step


def step_of(linear=None, first=(0, 0, 0)):
    out = numpy.eye(4)
    if linear is not None:
        out[:3, :3] = linear
    out[:3, 3] = first
    return out


def mirrored(stack, *axes):
    """Indices along these axes counted from the other end. Of two axes no mirror image comes."""
    images, linear, first = stack.images, numpy.eye(3), numpy.zeros(3)
    for axis in axes:
        images = numpy.flip(images, axis)
        linear[axis, axis] = -1
        first[axis] = images.shape[axis] - 1
    return dataclasses.replace(stack, images=images, affine=moved(stack.affine, step_of(linear, first)))


def transposed(stack):
    """Rows are stored as columns: the lattice's hand changes, the heart does not."""
    swap = numpy.array([[0, 1, 0], [1, 0, 0], [0, 0, 1]])
    return dataclasses.replace(stack, images=stack.images.swapaxes(0, 1),
                               affine=moved(stack.affine, step_of(swap)))


def quarter_turn(stack):
    return mirrored(transposed(stack), 0)


def turned(degrees):
    def change(stack):
        angle = numpy.deg2rad(degrees)
        linear = numpy.array([[numpy.cos(angle), -numpy.sin(angle)], [numpy.sin(angle), numpy.cos(angle)]])
        middle = (numpy.array(stack.images.shape[:2]) - 1) / 2
        first = middle - linear @ middle
        images = stack.each_image(lambda image: ndimage.affine_transform(image, linear, first, order=1))
        step = numpy.eye(4)
        step[:2, :2], step[:2, 3] = linear, first
        return dataclasses.replace(stack, images=images, affine=moved(stack.affine, step))
    return change


def pixels(mm):
    def change(stack):
        factor = mm / stack.pixel_mm
        shape = tuple(int(size / factor) for size in stack.images.shape[:2])
        blur = max(0.0, 0.5 * (factor - 1))  # no frequency that the new pixels do not hold

        def anew(image):
            return ndimage.affine_transform(ndimage.gaussian_filter(image, blur), numpy.diag([factor, factor]),
                                            output_shape=shape, order=1)
        return dataclasses.replace(stack, images=stack.each_image(anew, shape),
                                   affine=moved(stack.affine, numpy.diag([factor, factor, 1, 1])))
    return change


def size(times):
    def change(stack):
        return dataclasses.replace(stack, affine=numpy.diag([times, times, times, 1]) @ stack.affine, larger=times)
    return change


def contrast(exponent):
    def change(stack):
        bright = numpy.percentile(stack.images, 99.9)
        return stack.with_images(1000 * (stack.images / bright).clip(0, 4) ** exponent)
    return change


def noise(share):
    """Rician; the share is its standard deviation over what is bright."""
    def change(stack):
        sigma = share * numpy.percentile(stack.images, 99)
        random = numpy.random.default_rng(SEED)
        return stack.with_images(numpy.hypot(stack.images + random.normal(0, sigma, stack.images.shape),
                                             random.normal(0, sigma, stack.images.shape)))
    return change


def shading(times, axis):
    """A coil on one side: so many times brighter there than at the other end."""
    def change(stack):
        along = [1] * 4
        along[axis] = -1
        return stack.with_images(stack.images * times ** numpy.linspace(-0.5, 0.5, stack.images.shape[axis])
                                 .reshape(along))
    return change


def blur(deviation_pixels):
    def change(stack):
        return stack.with_images(ndimage.gaussian_filter(stack.images, (deviation_pixels, deviation_pixels, 0, 0)))
    return change


def field(mm, about):
    """A square of so many mm about the heart, or as much as there is."""
    def change(stack):
        middle = numpy.rint((numpy.linalg.inv(stack.affine) @ [*about, 1])[:2]).astype(int)
        half = int(mm / 2 / stack.pixel_mm)
        low = numpy.maximum(middle - half, 0)
        images = stack.images[low[0]:middle[0] + half, low[1]:middle[1] + half]
        return dataclasses.replace(stack, images=images, affine=moved(stack.affine, step_of(first=(*low, 0))))
    return change


def padded(mm):
    def change(stack):
        room = int(mm / stack.pixel_mm)
        images = numpy.pad(stack.images, ((room, room), (room, room), (0, 0), (0, 0)))
        return dataclasses.replace(stack, images=images,
                                   affine=moved(stack.affine, step_of(first=(-room, -room, 0))))
    return change


def every_second_slice(stack):
    if stack.images.shape[2] < 6:
        return None
    return dataclasses.replace(stack, images=stack.images[:, :, ::2],
                               affine=moved(stack.affine, numpy.diag([1, 1, 2, 1])))


def slices_between(stack):
    """Twice as many, each new one the mean of those beside it."""
    images = numpy.empty((*stack.images.shape[:2], 2 * stack.images.shape[2] - 1, stack.images.shape[3]),
                         numpy.float32)
    images[:, :, ::2] = stack.images
    images[:, :, 1::2] = (stack.images[:, :, 1:] + stack.images[:, :, :-1]) / 2
    return dataclasses.replace(stack, images=images, affine=moved(stack.affine, numpy.diag([1, 1, 0.5, 1])))


def fewer_phases(keep):
    """@param keep (phases of ED and ES, their number) -> those that stay"""
    def change(stack, ends):
        count = len(stack.phases)
        if count < 4:
            return None
        kept = sorted(set(keep(ends, count)))
        return dataclasses.replace(stack, images=stack.images[..., kept], phases=kept)
    change.needs_ends = True
    return change


def between(ends, count):
    """The phase in the middle of diastole, from ES on to ED."""
    return (ends[1] + ((ends[0] - ends[1]) % count) // 2) % count


def variations(about):
    """By name. @param about the middle of the heart [mm]"""
    out = {"as_it_is": lambda stack: stack, "quarter_turn": quarter_turn, "transposed": transposed,
           "slices_reversed": lambda stack: mirrored(stack, 0, 2)}
    out |= {f"turned_{d}": turned(d) for d in (30, -60)}
    out |= {f"pixels_{mm}_mm": pixels(mm) for mm in (1.0, 2.2)}
    out |= {f"size_{times}": size(times) for times in (0.45, 0.6, 0.8, 1.25)}
    out |= {f"gamma_{e}": contrast(e) for e in (0.6, 1.5)}
    out |= {f"noise_{share}": noise(share) for share in (0.03, 0.08)}
    out |= {"shading_i": shading(5, 0), "shading_j": shading(5, 1), "shading_k": shading(2, 2), "blur": blur(1.2),
            "field_160_mm": field(160, about), "padded": padded(80), "every_second_slice": every_second_slice,
            "slices_between": slices_between}
    out |= {"half_the_phases": fewer_phases(lambda ends, count: range(ends[0] % 2, count, 2)),
            "three_phases": fewer_phases(lambda ends, count: [*ends, between(ends, count)]),
            "two_phases": fewer_phases(lambda ends, count: ends)}
    return out
