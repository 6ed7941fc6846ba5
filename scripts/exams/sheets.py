"""One picture an exam: every slice at ED and ES with our outlines (lines) and the experts' (dots)."""
import json
import pathlib

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import nibabel
import numpy

from measures import ENDS, LABELS, Labels, drawn_labels, nearest_voxels

COLOURS = {"lv_blood": "#ff4040", "lv_myocardium": "#40e040", "rv_blood": "#50a0ff"}
MARGIN_MM = 30
TILE_INCHES = 2.2
MOST_COLUMNS = 6
UNKNOWN = 255  # a label that says nothing


def _window(masks, spacing, size):
    """(first, end) along i and j of what the masks hold, with a margin; all of it where they are empty."""
    held = [mask.any(axis=2) for mask in masks if mask.any()]
    if not held:
        return (0, size[0]), (0, size[1])
    held = numpy.logical_or.reduce(held)
    out = []
    for axis in (0, 1):
        at = numpy.flatnonzero(held.any(axis=1 - axis))
        margin = int(MARGIN_MM / spacing[axis])
        out.append((max(0, at[0] - margin), min(size[axis], at[-1] + margin + 1)))
    return tuple(out)


def _stack(study, as_acquired):
    """[i, j, k, phase], its affine, and how far each slice lies from where its labels do, in voxels:
    labels as acquired belong on slices that nobody moved, and the study holds them moved back, in place and time."""
    image = nibabel.load(pathlib.Path(study) / "exam" / "stack.nii.gz")
    values = numpy.asarray(image.dataobj)
    values = values if values.ndim == 4 else values[..., None]
    told = json.loads((pathlib.Path(study) / "exam" / "exam.json").read_text())
    shifts = told.get("slice_shifts_mm") or []
    if as_acquired:
        values = numpy.array(values)
        for k, lag in enumerate(told.get("slice_lags") or []):
            values[:, :, k] = numpy.roll(values[:, :, k], lag, axis=-1)
    spacing = numpy.linalg.norm(image.affine[:3, :3], axis=0)
    if not as_acquired or not shifts:
        shifts = numpy.zeros((values.shape[2], 2))
    return values, image.affine, numpy.asarray(shifts, float) / spacing[:2]


def _tile(axes, image, shift, layers):
    brightest = numpy.percentile(image, 99.5) or 1
    ni, nj = image.shape
    axes.imshow(image.T, cmap="gray", vmin=0, vmax=brightest, interpolation="bilinear",
                extent=(shift[0] - 0.5, ni - 0.5 + shift[0], nj - 0.5 + shift[1], -0.5 + shift[1]))
    for mask, colour, style, width in layers:
        if mask.any() and not mask.all():
            axes.contour(mask.T.astype(float), levels=[0.5], colors=colour, linestyles=style, linewidths=width)
    axes.set_xticks([])
    axes.set_yticks([])


def write_sheet(study, exam, data, name, file):
    """@throws OSError, KeyError where the study lacks images or labels"""
    labels = Labels(study)
    stack, affine, shifts = _stack(study, labels.as_acquired)
    size = stack.shape[:3]
    ends = []
    for end in ENDS:
        phase = labels.phase_at(exam, end)
        ours = labels.values[..., phase]
        drawn = drawn_labels(exam, end, data)
        theirs = numpy.zeros(size, numpy.uint8)
        if drawn is not None:
            theirs = nearest_voxels(*drawn, size, affine)
        ends.append((end, phase, ours, theirs))
    known = list(LABELS.values())
    (i0, i1), (j0, j1) = _window([numpy.isin(m, known) for e in ends for m in e[2:]],
                                 numpy.linalg.norm(affine[:3, :3], axis=0), size)
    columns = min(size[2], MOST_COLUMNS)
    lines = -(-size[2] // columns)  # of one phase
    figure, grid = plt.subplots(2 * lines, columns, squeeze=False, dpi=80,
                                figsize=(TILE_INCHES * columns, 2 * lines * TILE_INCHES + 0.6))
    for axes in grid.ravel():
        axes.set_axis_off()
    for n, (end, phase, ours, theirs) in enumerate(ends):
        for k in range(size[2]):
            axes = grid[n * lines + k // columns, k % columns]
            axes.set_axis_on()
            heart = (ours[..., k] > 0) & (ours[..., k] != UNKNOWN)
            layers = [(heart, "white", "solid", 0.6)]
            for structure, label in LABELS.items():
                layers.append((ours[..., k] == label, COLOURS[structure], "solid", 1.2))
                layers.append((theirs[..., k] == label, "#ffff60" if structure == "lv_blood" else "#ffa0ff",
                               "dotted", 1.6))
            _tile(axes, stack[..., k, phase], shifts[k], layers)
            axes.set_xlim(i0 - 0.5, i1 - 0.5)
            axes.set_ylim(j1 - 0.5, j0 - 0.5)
            axes.set_title(f"{end.upper()} phase {phase}, slice {k}", fontsize=7, pad=2)
    figure.suptitle(f"{name}: lines ours (heart white, LV red, muscle green, RV blue), dots the experts' (LV yellow, muscle pink)",
                    fontsize=9)
    figure.tight_layout(pad=0.3, rect=(0, 0, 1, 1 - 0.3 / figure.get_figheight()))
    figure.savefig(file)
    plt.close(figure)
