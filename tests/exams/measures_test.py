"""The scoreboard's arithmetic against closed forms: measures_test.py SOURCE_FOLDER"""
import json
import pathlib
import subprocess
import sys
import tempfile

import nibabel
import numpy

SOURCE = pathlib.Path(sys.argv[1])
sys.path.insert(0, str(SOURCE / "scripts" / "exams"))
import bands  # noqa: E402
import draws  # noqa: E402
import gates  # noqa: E402
import intervals  # noqa: E402
import measures  # noqa: E402
import sheets  # noqa: E402

SPACING = (1.5, 2.0, 8.0)  # mm
VOXEL_ML = 1.5 * 2.0 * 8.0 / 1000


def near(a, b, tolerance=1e-9):
    assert abs(a - b) <= tolerance, (a, b)


def box(size, low, high, label=1):
    out = numpy.zeros(size, numpy.uint8)
    out[tuple(slice(a, b) for a, b in zip(low, high))] = label
    return out


def affine_at(x=0.0, y=0.0, z=0.0):
    out = numpy.diag([*SPACING, 1.0])
    out[:3, 3] = (x, y, z)
    return out


def dice_of_boxes():
    """Two boxes of 10 x 10 x 2, three columns apart, share 7 of 10: 2 * 7 / (10 + 10)."""
    a, b = box((20, 20, 4), (2, 2, 1), (12, 12, 3)), box((20, 20, 4), (5, 2, 1), (15, 12, 3))
    near(measures.dice(a == 1, b == 1), 0.7)
    near(measures.dice(a == 1, a == 1), 1)
    near(measures.dice(a == 1, b == 2), 0)
    near(measures.dice(a == 2, b == 2), 0)


def volume_of_a_voxel():
    """Also of a grid that is turned and mirrored."""
    near(measures.voxel_ml(affine_at()), VOXEL_ML)
    turn = numpy.array([[0.6, -0.8, 0, 5], [0.8, 0.6, 0, 6], [0, 0, -1, 7], [0, 0, 0, 1]])
    near(measures.voxel_ml(turn @ affine_at(9)), VOXEL_ML, 1e-12)


def nearest_voxel_on_shifted_grids():
    """Less than half a voxel off reads the same voxel, more the next; outside is background."""
    labels = box((6, 6, 3), (2, 2, 1), (4, 4, 2), 3)
    for share, moved in ((0.0, 0), (0.4, 0), (0.6, 1), (-0.6, -1), (1.0, 1)):
        got = measures.nearest_voxels(labels, affine_at(), labels.shape, affine_at(share * SPACING[0]))
        assert (got == numpy.roll(labels, -moved, axis=0)).all(), share
    got = measures.nearest_voxels(labels, affine_at(), (6, 6, 3), affine_at(z=1000))
    assert not got.any()
    # A grid of half the voxel and twice the number sees each voxel as often as it has parts.
    fine = numpy.diag([SPACING[0] / 2, SPACING[1], SPACING[2], 1.0])
    fine[0, 3] = -SPACING[0] / 4
    got = measures.nearest_voxels(labels, affine_at(), (12, 6, 3), fine)
    assert (got == numpy.repeat(labels, 2, axis=0)).all()
    # A turn of the axes by 90 degrees is the same turn of the array.
    turned = affine_at()[:, [1, 0, 2, 3]]
    labels[2, 3, 1] = 1
    got = measures.nearest_voxels(labels, affine_at(), (6, 6, 3), turned)
    assert (got == labels.transpose(1, 0, 2)).all()


def phases_by_word_and_number():
    lv_ml = [50.0, 90.0, 20.0, 70.0]
    assert measures.phase_of("largest", 4, 4, lv_ml) == 1
    assert measures.phase_of("smallest", 4, 4, lv_ml) == 2
    assert measures.phase_of(3, 4, 4, lv_ml) == 3
    # 18 of 20 phases is 16.2 of 18, and the end of the beat is its beginning.
    assert measures.phase_of(18, 18, 20, lv_ml) == 16
    assert measures.phase_of(19, 5, 20, lv_ml) == 0


def study_of(folder, labels, stack_affine, source=None, shifts=None):
    """A study with these labels, and the same as acquired where `source` holds them."""
    study = folder / "made.study"
    (study / "segment").mkdir(parents=True, exist_ok=True)
    (study / "exam").mkdir(exist_ok=True)
    nibabel.Nifti1Image(labels, stack_affine).to_filename(study / "segment" / "labels.nii.gz")
    if source is not None:
        nibabel.Nifti1Image(source, stack_affine).to_filename(study / "segment" / "labels_source.nii.gz")
    images = numpy.where(labels > 0, 200, 50).astype(numpy.int16)
    nibabel.Nifti1Image(images, stack_affine).to_filename(study / "exam" / "stack.nii.gz")
    (study / "exam" / "exam.json").write_text(json.dumps({"slice_shifts_mm": shifts or []}))
    return study


def beat(size=(24, 20, 4)):
    """LV of 10 x 8 x 2 voxels at ED and 6 x 5 x 2 at ES, in a beat of two phases."""
    ed = box(size, (6, 6, 1), (16, 14, 3), 3)
    es = box(size, (8, 7, 1), (14, 12, 3), 3)
    return ed, es, numpy.stack([ed, es], axis=-1)


def expert(folder, ed, es, at):
    nibabel.Nifti1Image(ed, at).to_filename(folder / "ed.nii.gz")
    nibabel.Nifti1Image(es, at).to_filename(folder / "es.nii.gz")
    return {"source": "none", "phases_in_source": 2, "ed": {"labels": "ed.nii.gz", "phase": 0},
            "es": {"labels": "es.nii.gz", "phase": 1}}


def a_whole_score(folder):
    """The expert drew one of two slices at ED, and no muscle: neither counts against us."""
    ed, es, labels = beat()
    drawn = ed.copy()
    drawn[..., 2] = 0
    row = measures.score(study_of(folder, labels, affine_at()), expert(folder, drawn, es, affine_at()), folder)
    assert row["found"] and not row["as_acquired"] and list(row["ed"]) == ["lv_blood"], row
    near(row["ed"]["lv_blood"]["dice"], 1)
    near(row["ed"]["lv_blood"]["ml"], 80 * VOXEL_ML)
    near(row["es"]["lv_blood"]["ml"], 60 * VOXEL_ML)
    near(row["largest_ml"]["lv_blood"], 160 * VOXEL_ML, 1e-6)
    near(row["ef_same_slices"], 100 * (1 - 60 / 80))
    near(row["ef"], 100 * (1 - 60 / 160), 1e-6)
    assert not row["largest_ml"]["rv_blood"]


def slices_as_acquired(folder):
    """Labels moved by two voxels in a slice agree with the expert only where they are compared as
    acquired."""
    ed, es, acquired = beat()
    aligned = acquired.copy()
    aligned[:, :, 1] = numpy.roll(acquired[:, :, 1], 2, axis=0)
    drawn = expert(folder, ed, es, affine_at())
    row = measures.score(study_of(folder, aligned, affine_at()), drawn, folder)
    near(row["ed"]["lv_blood"]["dice"], 0.9)  # one slice of two keeps 8 of 10 columns
    shifts = [[0, 0], [-2 * SPACING[0], 0], [0, 0], [0, 0]]
    study = study_of(folder, aligned, affine_at(), acquired, shifts)
    row = measures.score(study, drawn, folder)
    assert row["as_acquired"]
    near(row["ed"]["lv_blood"]["dice"], 1)
    sheets.write_sheet(study, drawn, folder, "made", folder / "made.png")
    assert (folder / "made.png").stat().st_size > 5000


def what_a_gate_says():
    table = {"a": {"dice": {"ed": {"lv_blood": 0.93}}, "ef_points": 4},
             "b": {"reference_percent": {"ed": 20, "es": 25}}}
    good = {"exit": 0, "found": True, "ed": {"lv_blood": {"dice": 0.94}}, "ef_same_slices": 30.0, "expert_ef": 33.9}
    assert gates.failures("a", good, table) == []
    bad = {**good, "ed": {"lv_blood": {"dice": 0.92}}, "ef_same_slices": 29.8}
    said = gates.failures("a", bad, table)
    assert len(said) == 2 and "lv_blood at ED" in said[0] and "0.920" in said[0] and "29.8" in said[1], said
    assert "not compared" in gates.failures("a", {**good, "ed": {}}, table)[0]
    assert "exit code 3" in gates.failures("a", {"exit": 3, "verdict": "no heart"}, table)[0]
    assert "no left ventricle" in gates.failures("other", {"exit": 0, "found": False}, table)[0]
    volumes = {"exit": 0, "found": True, "reference_ml": {"lv_blood": [179, 72], "rv_blood": [211, 99]},
               "largest_ml": {"lv_blood": 179 * 1.19, "rv_blood": 211 * 0.81},
               "smallest_ml": {"lv_blood": 72 * 1.24, "rv_blood": 99 * 0.74}}
    said = gates.failures("b", volumes, table)
    assert len(said) == 1 and "rv_blood" in said[0] and "26 % off" in said[0], said
    # The table itself: names that the scores have.
    assert gates.read_gates()
    for exam, gate in gates.read_gates().items():
        for structures in gate.get("dice", {}).values():
            assert set(structures) <= set(measures.LABELS), exam


def surfaces_of_a_draw_over_its_phases():
    def entry(name, *phases):
        return {"name": name, "phases": [{"mean_mm": a, "p95_mm": 3 * a, "bias_mm": b} for a, b in phases]}
    row = draws.surface_errors({"drawn": [entry("lv_blood", (1, -1), (2, 0)),
                                          {**entry("heart", (0.5, 0.25)), "band_percent": 91.25},
                                          entry("la_blood", (9, 9)), entry("rv_blood")]})
    assert row == {"lv_mm": 1.5, "lv_p95_mm": 4.5, "lv_bias_mm": -0.5, "heart_mm": 0.5, "heart_p95_mm": 1.5,
                   "heart_bias_mm": 0.25, "heart_band_percent": 91.2}, row
    assert set(row) <= set(draws.COLUMNS)
    found = {"seed": 1, "outcome": "found", "has_heart": "yes", "phases": 2, "rendering": "box", **row}
    said = draws.summary([found], 0.85)
    assert draws.beyond([found], ["lv=1.6", "heart=0.5"]) == []
    assert "lv lie 1.50 mm off" in draws.beyond([found], ["lv=1.4"])[0]
    assert draws.beyond([found], ["rv=9"]) == ["no surface of rv was compared"]
    assert "surfaces of 1 [mm]" in said and "lv_bias_mm          -0.50" in said, said


def terms_of_a_band():
    """Two labelled slices of four, 10 mm apart along z; the base lies at low indices."""
    belief = numpy.array([[0, 100, 200, 0], [20, 90, 210, 0], [0, 80, 190, 0]], float)
    doubt = [20 / (2 * numpy.sqrt(20 * numpy.pi)), 30 / (2 * numpy.sqrt(100 * numpy.pi)),
             30 / (2 * numpy.sqrt(210 * numpy.pi)), 0]
    along_z = numpy.array([0, 0, 0.1, 0])
    slanted = [0.6, 0, -0.8]
    places = numpy.array([[5, 5, 10], [5, 5, 10], [5, 5, 14], [5, 5, 99], [5, 5, -40]], float)
    normals = numpy.array([[0, 1, 0], [0, 0, 1], slanted, slanted, slanted], float)
    terms, zone = bands.terms_of(places, normals, belief, along_z, 10, -1)
    wanted = [[1, doubt[1], 0, 0, 0], [0, 0, 0, 10, 0], [0.6, 0.6 * (0.6 * doubt[1] + 0.4 * doubt[2]), 0, 8 * 0.6, 8 * 0.4],
              [0.6, 0.6 * doubt[3], 0, 0, 8], [0.6, 0.6 * doubt[0], 0, 8, 0]]
    assert numpy.allclose(terms, wanted), terms
    assert [bands.ZONES[n] for n in zone] == ["base", "base", "base", "apex", "base"], zone
    turned, _ = bands.terms_of(places, normals, belief, along_z, 10, 1)
    assert numpy.allclose(turned[:, [0, 1, 2, 4, 3]], terms), "base and apex change places"


def bands_fitted_to_draws():
    """Errors that are even up to twice the doubt within slices, and up to half of the slices' distance along them: nine
    tenths lie below 1.8 and .45 of these."""
    random = numpy.random.default_rng(2)
    rows = []
    for seed in range(60):
        for _ in range(60):
            sine, doubt = random.uniform(0, 1), random.uniform(0.5, 3)
            cosine = numpy.sqrt(1 - sine ** 2)
            most = 2 * sine * doubt if sine > 0.7 else 0.5 * 8 * cosine
            row = dict.fromkeys(bands.COLUMNS, 0.0)
            row.update({"seed": seed, "structure": "heart", "zone": "middle", "gap_mm": 8, "sin": sine if sine > 0.7 else 0,
                        "sin x doubt": sine * doubt if sine > 0.7 else 0, "off_mm": random.uniform(-most, most),
                        "cos x gap, middle": 0 if sine > 0.7 else 8 * cosine})
            rows += [row] + [{**row, "structure": structure} for structure in bands.STRUCTURES[1:]]
    vertices = bands.Vertices(rows)
    numbers = bands.fitted(vertices, vertices.seed >= 0)["heart"]
    near(numbers[1], 1.8, 0.15)
    near(numbers[2], 0.45, 0.02)
    assert (numbers >= 0).all()
    for structure, zone, share, _, _ in bands.coverage(vertices, bands.left_out(vertices)):
        near(share, 0.9, 0.02)


def intervals_fitted_to_draws():
    """Truths that are even between the figure less `less` and the figure and twice `more`: 4 in 100 lie beyond
    1.92 `more` - .04 `less` above, and beyond .96 `less` - .08 `more` below; bounds whose numbers are 0 or more come
    close to both."""
    random = numpy.random.default_rng(1)
    rows = []
    for seed in range(400):
        figure, more, less = random.uniform(50, 200), random.uniform(0, 20), random.uniform(0, 20)
        truth = figure + random.uniform(-less, 2 * more)
        rows.append({"seed": seed, "lv_edv_ml": str(figure), "lv_edv_ml_truth": str(truth),
                     "lv_edv_ml_more": str(more), "lv_edv_ml_less": str(less)})
    below, above = intervals.margins(rows, "lv_edv_ml")
    near(above[1], 1.85, 0.08)
    near(below[1], 0.8, 0.15)
    for row in rows:
        figure, more, less = (float(row["lv_edv_ml" + what]) for what in ("", "_more", "_less"))
        row["lv_edv_ml_low"] = figure - below @ (figure, less, more)
        row["lv_edv_ml_high"] = figure + above @ (figure, more, less)
    count, inside, below_share, above_share, _ = intervals.coverage(rows, "lv_edv_ml")
    near(inside, 0.92, 0.03)
    near(below_share, 0.04, 0.02)
    near(above_share, 0.04, 0.02)
    assert intervals.coverage(rows, "rv_edv_ml") is None
    assert intervals.case_of(rows[0], "lv_sv_ml") is None
    both = {**rows[0], "lv_edv_ml": 100, "lv_edv_ml_truth": 110, "lv_edv_ml_more": 4, "lv_edv_ml_less": 2,
            "lv_esv_ml": 40, "lv_esv_ml_truth": 33, "lv_esv_ml_more": 1, "lv_esv_ml_less": 5}
    assert intervals.case_of(both, "lv_sv_ml") == (60, 77, 100, 9, 3)
    assert numpy.allclose(intervals.case_of(both, "lv_ef_percent"), (60, 70, 100, 9, 3))


def intervals_of_a_report():
    belief = {"labelled_mm2": [[0, 1000, 0, 0], [0, 500, 0, 0]], "expected_mm2": [[300, 900, 0, 50], [0, 500, 0, 0]],
              "agreed_mm2": [[0, 800, 0, 0], [0, 450, 0, 0]]}
    report = {"figures": {"lv_edv_ml": 10, "lv_esv_ml": 5, "lv_mass_g": None}, "volumes_ml": {"lv_blood": [10, 5]},
              "intervals_90": {"lv_edv_ml": [8, 13]}}
    row = intervals.columns(report, {"lv_blood": belief}, 10.0, {"lv_blood": [4, 11]})
    assert row == {"lv_edv_ml": 10, "lv_edv_ml_truth": 11, "lv_edv_ml_more": 4, "lv_edv_ml_less": 2, "lv_esv_ml": 5,
                   "lv_esv_ml_truth": 4, "lv_esv_ml_more": 0.5, "lv_esv_ml_less": 0.5, "lv_edv_ml_low": 8,
                   "lv_edv_ml_high": 13}, row
    assert set(row) <= set(draws.COLUMNS)
    good = {**row, "lv_ed": 0.9, "lv_es": 0.9, "rv_ed": 0.9, "rv_es": 0.9, "muscle_ed": 0.8, "reported": "yes",
            "reasons": "muscle"}
    assert draws.is_right(good) and not draws.is_right({**good, "lv_edv_ml": 12.2})
    assert not draws.is_right({**good, "rv_es": 0.6}) and not draws.is_right({**good, "lv_edv_ml": ""})
    said = "\n".join(draws.summary_of_intervals([good]) + draws.summary_of_reasons([good, {**good, "reasons": ""}]))
    assert "lv_edv_ml     1 100 %" in said and "muscle                    1 of 2 right, 0 of 0 wrong" in said, said
    assert "none                      1 of 2 right" in said, said


def the_command_line(folder):
    """A beatlas that fails loses its exam, by name; where there are no exams a test is skipped."""
    data = folder / "data"
    data.mkdir()
    script = SOURCE / "scripts" / "score_exams"

    def run(*words):
        return subprocess.run([sys.executable, "-B", script, *map(str, words)], capture_output=True, text=True)
    done = run(data, "--skip-absent")
    assert done.returncode == 77 and "skipped" in done.stdout, done
    assert run(data).returncode == 1
    (data / "exams.json").write_text(json.dumps({"one/exam": {"source": "one"}}))
    done = run(data, "--beatlas", "false", "--gates", "--json", folder / "rows.json")
    assert done.returncode == 1 and "GATE one/exam: beatlas ended with exit code 1" in done.stderr, done
    assert "LOST" in done.stdout and not json.loads((folder / "rows.json").read_text())["one/exam"]["found"]
    assert "| one/exam | LOST |" in run(data, "--beatlas", "false", "--markdown").stdout
    assert "has no exam two" in run(data, "--beatlas", "false", "--only", "two").stderr


for check in (dice_of_boxes, volume_of_a_voxel, nearest_voxel_on_shifted_grids, phases_by_word_and_number,
              what_a_gate_says, surfaces_of_a_draw_over_its_phases, terms_of_a_band, bands_fitted_to_draws,
              intervals_fitted_to_draws, intervals_of_a_report):
    check()
for check in (a_whole_score, slices_as_acquired, the_command_line):
    with tempfile.TemporaryDirectory(prefix="beatlas-exams-") as folder:
        check(pathlib.Path(folder))
