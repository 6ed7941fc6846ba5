"""Bands of surfaces: what of drawn hearts they are fitted to, the fit, and how well they hold.

pipeline/build/surface_bands.h says what a band's half width is made of: of a vertex the sum of TERMS, each times a
number of its structure. Draws have no slice that a person labelled.
"""
import csv
import json

import numpy

from intervals import quantile_regression

STRUCTURES = ("heart", "lv_blood", "rv_blood", "lv_myocardium")
# sin: of the angle between the surface's normal and the slices'; gap: distance of the slices [mm]; the last three hold
# at the structure's last slice toward the base, between, and at that toward the apex.
TERMS = ("sin", "sin x doubt", "cos x gap, middle", "cos x gap, base", "cos x gap, apex")
COLUMNS = ["seed", "structure", "end_systole", "zone", "gap_mm", *TERMS, "off_mm"]
ZONES = ("middle", "base", "apex")
SHARE = 0.9  # of the surface, that a band should hold
SAMPLED = 400  # vertices of a structure and phase: neighbours err alike
LEAST_DRAWS = 50  # to fit to


def _doubt_mm(labelled, expected, agreed):
    """[slice] how far off an outline is likely to lie; nothing far from what is labelled."""
    larger = numpy.maximum(labelled, expected)
    outline = 2 * numpy.sqrt(numpy.pi * numpy.maximum(larger, 1e-9))  # of a circle of that area
    doubt = numpy.maximum(0, labelled + expected - 2 * agreed) / outline
    near = numpy.convolve(labelled > 0, [1, 1, 1])[1:-1] > 0
    return numpy.where(near & (larger > 0), doubt, 0)


def terms_of(places, normals, belief, slice_from_workspace, gap, base_step):
    """(TERMS of each vertex, its zone) @param places, normals [vertex][3], workspace @param belief (labelled, expected,
    agreed) area of each slice [mm2] @param slice_from_workspace row of 4 @param gap distance of the slices [mm]
    @param base_step +1 where the base lies at larger slice index"""
    steepness = numpy.linalg.norm(slice_from_workspace[:3])
    labelled = numpy.flatnonzero(belief[0] > 0)
    last = len(belief[0]) - 1
    within = (places @ slice_from_workspace[:3] + slice_from_workspace[3]).clip(0, last)
    cosine = numpy.abs(normals @ slice_from_workspace[:3] / steepness).clip(0, 1)
    sine = numpy.sqrt(1 - cosine ** 2)
    doubt = numpy.interp(within, numpy.arange(last + 1), _doubt_mm(*belief))
    low, high = (numpy.clip(1 - inward, 0, 1) for inward in (within - labelled[0], labelled[-1] - within))
    base, apex = (low, high) if base_step < 0 else (high, low)
    middle = numpy.maximum(0, 1 - base - apex)
    terms = numpy.stack([sine, sine * doubt, cosine * gap * middle, cosine * gap * base, cosine * gap * apex], 1)
    zone = numpy.where(base > 0, 1, numpy.where(apex > 0, 2, 0))
    return terms, zone


def rows_of(seed, study, info, vertices):
    """What of a draw is fitted to. @param study its folder @param info what `beatlas info --json` prints of the package
    @param vertices what `beatlas validate --vertices` wrote"""
    segment = json.loads((study / "segment" / "segment.json").read_text())
    axis = json.loads((study / "segment" / "long_axis.json").read_text())
    source, workspace = (numpy.array(matrix).reshape(4, 4) for matrix in
                         (info["source"]["lps_from_index"], info["workspace_from_lps"]))
    slice_from_workspace = numpy.linalg.inv(workspace @ source)[2]
    gap = float(numpy.linalg.norm(source[:3, 2]))
    base_step = 1 if numpy.dot(axis["towards_base_lps"], source[:3, 2]) > 0 else -1
    beliefs = {belief["structure"]: belief for belief in segment["belief"]}
    with vertices.open(newline="") as file:
        told = list(csv.DictReader(file))
    chance = numpy.random.default_rng(seed)
    out = []
    for structure in STRUCTURES:
        for phase in sorted({int(row["phase"]) for row in told}):
            own = [row for row in told if row["structure"] == structure and int(row["phase"]) == phase
                   and float(row["area_mm2"]) > 0]
            if not own or structure not in beliefs:
                continue
            belief = numpy.array([beliefs[structure][key][phase]
                                  for key in ("labelled_mm2", "expected_mm2", "agreed_mm2")])
            # Of one slice the program takes the wider of both ends, which is no sum of terms.
            if (belief[0] > 0).sum() < 2:
                continue
            area = numpy.array([float(row["area_mm2"]) for row in own])
            taken = chance.choice(len(own), min(SAMPLED, len(own)), replace=False, p=area / area.sum())
            number = numpy.array([[float(own[at][key]) for key in ("x_mm", "y_mm", "z_mm", "nx", "ny", "nz", "off_mm")]
                                  for at in taken])
            terms, zone = terms_of(number[:, :3], number[:, 3:6], belief, slice_from_workspace, gap, base_step)
            out += [[seed, structure, int(phase == segment["end_systole"]), ZONES[zone[n]], round(gap, 3),
                     *(round(term, 4) for term in terms[n]), number[n, 6]] for n in range(len(taken))]
    return out


class Vertices:
    """Rows of draws, as columns of numbers."""

    def __init__(self, rows):
        self.seed = numpy.array([int(row["seed"]) for row in rows])
        self.structure = numpy.array([row["structure"] for row in rows])
        self.zone = numpy.array([row["zone"] for row in rows])
        self.gap = numpy.array([float(row["gap_mm"]) for row in rows])
        self.terms = numpy.array([[float(row[term]) for term in TERMS] for row in rows])
        self.off = numpy.array([abs(float(row["off_mm"])) for row in rows])


def _weights(vertices, own):
    """Every heart counts alike in each zone, so that none alone decides; a zone counts by its vertices."""
    out = numpy.ones(own.sum())
    for zone in ZONES:
        there = vertices.zone[own] == zone
        if there.any():
            _, heart, count = numpy.unique(vertices.seed[own][there], return_inverse=True, return_counts=True)
            out[there] = there.sum() / (len(count) * count[heart])
    return out


def fitted(vertices, taken):
    """[structure] numbers of TERMS, from the rows `taken`."""
    out = {}
    for structure in STRUCTURES:
        own = taken & (vertices.structure == structure)
        out[structure] = quantile_regression(vertices.terms[own], vertices.off[own], 1 - SHARE, _weights(vertices, own))
    return out


def left_out(vertices, folds=10):
    """[row] half width told by a fit to draws of other folds."""
    out = numpy.zeros(len(vertices.off))
    order = {seed: n % folds for n, seed in enumerate(sorted(set(vertices.seed.tolist())))}
    fold = numpy.array([order[seed] for seed in vertices.seed.tolist()])
    for n in range(folds):
        for structure, numbers in fitted(vertices, fold != n).items():
            own = (fold == n) & (vertices.structure == structure)
            out[own] = vertices.terms[own] @ numbers
    return out


def coverage(vertices, half_width):
    """[(structure, zone or "all", share of the surface within, mm: the half width's median, the error's 90 %)]"""
    out = []
    for structure in STRUCTURES:
        for zone in ("all", *ZONES):
            own = (vertices.structure == structure) & ((vertices.zone == zone) | (zone == "all"))
            if own.any():
                out.append((structure, zone, float(numpy.mean(vertices.off[own] <= half_width[own])),
                            float(numpy.median(half_width[own])), float(numpy.quantile(vertices.off[own], SHARE))))
    return out
