"""90 % prediction intervals of an exam's figures: what of draws they are fitted to, the fit, and how well they hold.

pipeline/report/prediction_intervals.h says what a bound is made of. Per figure of MEASURED a row of a draw holds the
figure itself, the truth's, and what the prior expects beside what is labelled: `_more` is expected and not labelled,
`_less` the other way round.
"""
import numpy

DENSITY = 1.05  # of muscle [g/ml]
VENTRICLES = (("lv", "lv_blood"), ("rv", "rv_blood"))
MEASURED = ("lv_edv_ml", "lv_esv_ml", "rv_edv_ml", "rv_esv_ml", "lv_mass_g")  # the others of KEYS follow from these
KEYS = ("lv_edv_ml", "lv_esv_ml", "lv_sv_ml", "lv_ef_percent", "rv_edv_ml", "rv_esv_ml", "rv_sv_ml", "rv_ef_percent",
        "lv_mass_g")
COLUMNS = [key + what for key in MEASURED for what in ("", "_truth", "_more", "_less")]
COLUMNS += [f"{key}_{end}" for key in KEYS for end in ("low", "high")]
# Below, and above, of the draws that are fitted to: less than a twentieth, for of those left out a few more lie beyond.
# Of 144 draws (9000 to 9275), a tenth left out each time, 88 % lie within with a tail of .05, and 90 % so.
TAIL = 0.04
LEAST_DRAWS = 100  # to fit to


def about_labels(belief, phase):
    """Labelled, expected and agreed area [mm2] of a structure in a phase, over the slices that hold labels and the
    next ones: pipeline/core/belief.h."""
    areas = numpy.array([belief[key][phase] for key in ("labelled_mm2", "expected_mm2", "agreed_mm2")])
    near = numpy.convolve(areas[0] > 0, [1, 1, 1], "same") > 0
    return areas[:, near].sum(axis=1)


def _beside(belief, phase, distance_mm):
    """(more, less) [ml]"""
    labelled, expected, agreed = about_labels(belief, phase) * distance_mm * 1e-3
    return expected - agreed, labelled - agreed


def columns(report, beliefs, distance_mm, truth_ml):
    """@param report what `beatlas report --json` prints @param beliefs of segment.json, by structure
    @param truth_ml the truth's volumes in the slices, by structure, a value a phase"""
    row = {}
    for name, structure in VENTRICLES:
        curve = report["volumes_ml"].get(structure)
        if curve is None or structure not in beliefs:
            continue
        for end, at in (("edv", numpy.argmax), ("esv", numpy.argmin)):
            key = f"{name}_{end}_ml"
            more, less = _beside(beliefs[structure], int(at(curve)), distance_mm)
            truth = truth_ml[structure][at(truth_ml[structure])]
            row.update({key: report["figures"][key], f"{key}_truth": float(truth), f"{key}_more": more,
                        f"{key}_less": less})
    if report["figures"].get("lv_mass_g") is not None and "lv_myocardium" in beliefs:
        phase = int(numpy.argmax(report["volumes_ml"]["lv_blood"]))
        more, less = _beside(beliefs["lv_myocardium"], phase, distance_mm)
        true_phase = int(numpy.argmax(truth_ml["lv_blood"]))
        row.update({"lv_mass_g": report["figures"]["lv_mass_g"], "lv_mass_g_more": DENSITY * more,
                    "lv_mass_g_truth": DENSITY * float(truth_ml["lv_myocardium"][true_phase]),
                    "lv_mass_g_less": DENSITY * less})
    for key, (low, high) in report.get("intervals_90", {}).items():
        row.update({f"{key}_low": low, f"{key}_high": high})
    return {column: round(value, 3) for column, value in row.items()}


def _known(row, *names):
    return all(row.get(name) not in (None, "") for name in names)


def case_of(row, key):
    """(figure, truth, scale, more, less) of one draw, or None: what a bound of the figure is made of."""
    if key in MEASURED:
        names = [key + what for what in ("", "_truth", "_more", "_less")]
        if not _known(row, *names):
            return None
        figure, truth, more, less = (float(row[name]) for name in names)
        return (figure, truth, figure, more, less) if figure > 0 else None
    name = key[:2]
    ed, es = case_of(row, f"{name}_edv_ml"), case_of(row, f"{name}_esv_ml")
    if ed is None or es is None or ed[1] <= 0:
        return None
    more, less = ed[3] + es[4], ed[4] + es[3]
    if key.endswith("sv_ml"):
        return ed[0] - es[0], ed[1] - es[1], ed[0], more, less
    percent = 100 / ed[0]
    return 100 * (1 - es[0] / ed[0]), 100 * (1 - es[1] / ed[1]), 100.0, more * percent, less * percent


def quantile_regression(features, values, tail, weights=1):
    """Numbers of 0 or more with which features, summed, exceed all but `tail` of the values (Koenker, Bassett 1978).
    Solved by its dual, which has a row for each feature instead of one for each value. @param weights of the values"""
    from scipy.optimize import linprog
    bounds = numpy.ones(len(values)) * weights
    dual = linprog(-values, A_ub=features.T, b_ub=numpy.zeros(features.shape[1]),
                   bounds=numpy.c_[-tail * bounds, (1 - tail) * bounds])
    if dual.status != 0:
        raise ValueError(f"the fit has no solution: {dual.message}")
    return numpy.maximum(0, -dual.ineqlin.marginals)


def margins(rows, key):
    """((scale, own, other) below, the same above)."""
    cases = numpy.array([case for case in (case_of(row, key) for row in rows) if case is not None])
    if len(cases) < LEAST_DRAWS:
        raise ValueError(f"{key} is known of {len(cases)} draws; a twentieth of them are too few to fit to")
    figure, truth, scale, more, less = cases.T
    below = quantile_regression(numpy.c_[scale, less, more], figure - truth, TAIL)
    above = quantile_regression(numpy.c_[scale, more, less], truth - figure, TAIL)
    return below, above


def coverage(rows, key):
    """(draws, share of truths within the interval, below it, above it, median of half its width) or None."""
    cases = []
    for row in rows:
        case = case_of(row, key)
        if case is not None and _known(row, f"{key}_low", f"{key}_high"):
            cases.append((case[1], float(row[f"{key}_low"]), float(row[f"{key}_high"])))
    if not cases:
        return None
    truth, low, high = numpy.array(cases).T
    below, above = float(numpy.mean(truth < low)), float(numpy.mean(truth > high))
    return len(cases), 1 - below - above, below, above, float(numpy.median((high - low) / 2))
