"""What a variation moves in space its affine tells: variations_test.py SOURCE

On a stack in which each voxel's value is its place along a slanting direction, taken from the affine.
"""
import pathlib
import sys
import unittest

import numpy

sys.path.insert(0, str(pathlib.Path(sys.argv.pop()) / "scripts" / "exams"))
sys.dont_write_bytecode = True
import variations  # noqa: E402

ALONG = numpy.array([1.0, 0.7, 0.4])
ENDS = [8, 3]
AFFINE = numpy.array([[1.2, 0.3, 0.1, -30], [-0.2, 1.3, 0.4, -40], [0.1, -0.3, 7.9, 20], [0, 0, 0, 1]])
BRIGHT = ("gamma", "noise", "shading", "blur")  # change what is seen, not where


def places(shape, affine):
    index = numpy.indices(shape).reshape(3, -1)
    return (affine[:3, :3] @ index + affine[:3, 3:]).reshape(3, *shape)


def along(shape, affine):
    return numpy.tensordot(ALONG, places(shape, affine), 1)


def stack():
    values = along((60, 56, 7), AFFINE) + 300
    return variations.Stack(numpy.stack([values] * 10, 3).astype(numpy.float32), AFFINE, list(range(10)))


class Variations(unittest.TestCase):
    def test_every_voxel_lies_where_its_affine_says(self):
        for name, change in variations.variations((10, 10, 40)).items():
            if name.startswith(BRIGHT):
                continue
            with self.subTest(name):
                plain = stack()
                varied = change(plain, ENDS) if getattr(change, "needs_ends", False) else change(plain)
                affine = numpy.diag([1 / varied.larger] * 3 + [1]) @ varied.affine
                told = along(varied.images.shape[:3], affine) + 300
                # Beyond the images there is nothing, and at their edge a mean with it.
                old = numpy.linalg.inv(AFFINE) @ numpy.vstack(
                    [places(told.shape, affine).reshape(3, -1), numpy.ones(told.size)])
                inside = ((old[:3] > 1) & (old[:3] < numpy.array([[58], [54], [6.01]]))).all(0).reshape(told.shape)
                self.assertGreater(inside.sum(), 100)
                gap = abs(varied.images[..., 0] - told)[inside].max()
                self.assertLess(gap, 0.5 if "mm" in name and "pixels" in name else 0.01)

    def test_no_mirror_image_comes_of_it(self):
        for name, change in variations.variations((10, 10, 40)).items():
            plain = stack()
            varied = change(plain, ENDS) if getattr(change, "needs_ends", False) else change(plain)
            hand = numpy.linalg.det(varied.affine[:3, :3]) / numpy.linalg.det(AFFINE[:3, :3])
            (self.assertLess if name == "transposed" else self.assertGreater)(hand, 0, name)

    def test_phases_of_both_ends_stay_where_they_are_compared(self):
        for name, kept in (("half_the_phases", [0, 2, 4, 6, 8]), ("three_phases", [3, 5, 8]), ("two_phases", [3, 8])):
            varied = variations.variations((0, 0, 0))[name](stack(), ENDS)
            self.assertEqual(varied.phases, kept)
            self.assertEqual(varied.images.shape[3], len(kept))

    def test_a_stack_of_few_slices_or_phases_is_left(self):
        short = stack()
        short.images, short.phases = short.images[:, :, :4, :2], [0, 1]
        every = variations.variations((0, 0, 0))
        self.assertIsNone(every["every_second_slice"](short))
        self.assertIsNone(every["three_phases"](short, [0, 1]))


unittest.main()
