"""The whole chain on a small phantom: stage_test.py BEATLAS WORK_FOLDER NAME"""
import hashlib
import json
import pathlib
import re
import shutil
import subprocess
import sys
import zipfile

import jsonschema
import nibabel
import numpy

PROGRAM, WORK = sys.argv[1], pathlib.Path(sys.argv[2])
EXAM, PACKAGE, STUDY, TIMING = WORK / "phantom" / "dicom", WORK / "study.beatlas", WORK / "study", WORK / "timing.json"
STAGES = ("segment", "register", "field", "mesh")
# As few as a report calls enough.
PHASES = 8


def beatlas(*words, code=0):
    done = subprocess.run([PROGRAM, *map(str, words)], capture_output=True, text=True)
    assert code is None or done.returncode == code, f"{words}: exit code {done.returncode}\n{done.stderr}"
    return done


def digest(file):
    return hashlib.sha256(pathlib.Path(file).read_bytes()).hexdigest()


def expect_same(a, b):
    if digest(a) == digest(b):
        return
    told = []
    with zipfile.ZipFile(a) as first, zipfile.ZipFile(b) as second:
        for name in sorted(set(first.namelist()) | set(second.namelist())):
            here = first.read(name) if name in first.namelist() else b""
            there = second.read(name) if name in second.namelist() else b""
            if here != there:
                told.append(name)
    sys.exit(f"{a} and {b} differ in {told or 'the order or headers of the zip'}")


def new_folder(name):
    folder = WORK / name
    shutil.rmtree(folder, ignore_errors=True)
    return folder


def prepare():
    shutil.rmtree(WORK, ignore_errors=True)
    WORK.mkdir(parents=True)
    said = beatlas("phantom", "-o", WORK / "phantom", "--preset", "small", "--without", "all", "--phases", PHASES).stdout
    assert pathlib.Path(said.strip()) == EXAM, said
    done = beatlas("build", EXAM, "-o", PACKAGE, "--study", STUDY, "--timing", TIMING)
    assert done.stdout == "", "build prints no data"
    assert "The stack is made of 44 parallel slices" in done.stderr, done.stderr


def threads():
    """The same bytes twice and for any number of threads."""
    for count in (1, 3):
        beatlas("build", EXAM, "-o", WORK / f"threads{count}.beatlas", "--threads", count)
        expect_same(PACKAGE, WORK / f"threads{count}.beatlas")


def scenes():
    """A scene holds what it names, from build or study: the same bytes as in the full package, but for an endocardium
    alone, which makes room for nothing (BuildAtlas.MakesWhatTheSceneNeedsAndNoMore)."""
    with zipfile.ZipFile(PACKAGE) as whole:
        payloads = {name: whole.read(name) for name in whole.namelist() if name != "atlas.json"}
    folder = new_folder("scenes")
    shutil.copytree(STUDY, folder)
    assert {"maps/lv_blood.map.zst", "maps/lv_myocardium.map.zst"} <= set(payloads), set(payloads)
    of_lv = ("fields/heart", "surfaces/lv_blood", "maps/lv_blood")
    for scene, prefix in (("palpation", of_lv), ("anatomy", ("surfaces/", "maps/"))):
        small = WORK / f"{scene}.beatlas"
        beatlas("pack", "--study", folder, "-o", small, "--scene", scene)
        if scene == "palpation":  # a whole build takes a while: one scene stands for both
            beatlas("build", EXAM, "-o", WORK / "built.beatlas", "--scene", scene)
            expect_same(small, WORK / "built.beatlas")
        with zipfile.ZipFile(small) as part:
            names = [name for name in part.namelist() if name != "atlas.json"]
            # A finger feels one level of detail; what draws has two.
            expected = [name for name in payloads if name.startswith(prefix)
                        and (scene != "palpation" or ".level" not in name)]
            assert names == expected, names
            for name in names:
                alone = scene == "palpation" and name.startswith("surfaces/")
                assert alone or part.read(name) == payloads[name], name
        info = json.loads(beatlas("info", small, "--json").stdout)
        full = json.loads(beatlas("info", PACKAGE, "--json").stdout)
        assert info["structures"] == full["structures"], "volume curves are in every package"


def study():
    """A study holds standard formats in the patient's frame, pictures, and what was done."""
    folder = STUDY
    stack = nibabel.load(folder / "exam" / "stack.nii.gz")
    labels = nibabel.load(folder / "segment" / "labels.nii.gz")
    assert stack.shape == labels.shape
    assert numpy.allclose(stack.affine, labels.affine, atol=1e-4)
    # The workspace's images overlay the source: the same centroid of the heart in the patient.
    moved = nibabel.load(folder / "register" / "labels.nii.gz")
    assert moved.shape[:3] == (256, 256, 64), moved.shape
    centroids = []
    for image in (labels, moved):
        inside = numpy.argwhere(numpy.asarray(image.dataobj)[..., 0] > 0)
        centroids.append(nibabel.affines.apply_affine(image.affine, inside.mean(axis=0)))
    # Half of the larger voxel's diagonal in-plane; both are means over thousands of voxels.
    assert numpy.linalg.norm(centroids[0] - centroids[1]) < 1.5, centroids
    assert (folder / "pictures" / "overlay.png").read_bytes()[:8] == b"\x89PNG\r\n\x1a\n"
    assert "<polyline" in (folder / "pictures" / "volumes.svg").read_text()
    record = json.loads((folder / "study.json").read_text())
    for stage in ("import", *STAGES, "pack"):
        assert record["stages"][stage]["outputs"], stage
        for file, wanted in record["stages"][stage]["outputs"].items():
            assert digest(folder / file) == wanted, file
    spent = json.loads(TIMING.read_text())
    assert [entry["name"] for entry in spent["stages"]] == ["import", "segment", "pictures", *STAGES[1:], "pack", "report"]
    assert spent["peak_memory_mb"] > 10 and spent["wall_s"] > 0
    assert not list(folder.rglob(".partial*"))


def info():
    truth = json.loads((WORK / "phantom" / "truth.json").read_text())
    told = json.loads(beatlas("info", PACKAGE, "--json").stdout)
    assert abs(told["rr_interval_s"] - truth["rr_interval_s"]) < 2e-3, "R-R is whole ms in DICOM"
    assert len(told["frame_times_s"]) == truth["spec"]["phases"]
    assert {entry["name"] for entry in told["structures"]} == {
        "heart", "lv_blood", "rv_blood", "lv_myocardium"}
    assert len(told["workspace_from_lps"]) == 16
    with zipfile.ZipFile(PACKAGE) as package:
        assert {item["path"] for item in told["items"]} == set(package.namelist()) - {"atlas.json"}
        for item in told["items"]:
            entry = package.read(item["path"])
            assert len(entry) == item["bytes"]
            assert hashlib.sha256(entry).hexdigest() == item["sha256"]
        # The key of a phantom's identity is no path.
        everything = package.read("atlas.json").decode().replace('"phantom_identity":', "")
    for word in (str(WORK), "phantom", "dicom/", "/build"):
        assert word not in everything, f"{word} in the manifest: no path may enter a package"
    assert set(told["provenance"]["stages"]) == {"import", *STAGES, "pack"}


def export():
    """Labels on the source's grid agree with the truth; a study gives its cine; OBJ is closed."""
    out = new_folder("export")
    beatlas("export", PACKAGE, "--to", "nifti", "-o", out)
    labels = nibabel.load(out / "labels.nii.gz")
    truth = nibabel.load(WORK / "phantom" / "truth_labels.nii.gz")
    assert labels.shape == truth.shape
    assert numpy.allclose(labels.affine, truth.affine, atol=1e-3)
    a, b = numpy.asarray(labels.dataobj), numpy.asarray(truth.dataobj)
    for name, inside in (("heart", lambda x: x > 0), ("lv_blood", lambda x: x == 3)):
        dice = 2 * (inside(a) & inside(b)).sum() / (inside(a).sum() + inside(b).sum())
        # Published human readers agree to about 0.95; below 0.9 something is misplaced.
        assert dice > 0.9, f"{name}: Dice {dice:.3f}"
    # Every label that is there has a name and a colour of its own in both programs' tables.
    for table, at in (("labels.txt", 1), ("labels.ctbl", 2)):
        rows = [line.split() for line in (out / table).read_text().splitlines() if not line.startswith("#")]
        colours = {int(row[0]): tuple(row[at:at + 3]) for row in rows}
        assert set(numpy.unique(a)) <= set(colours) and len(set(colours.values())) == len(colours), table
    cine = nibabel.load(out / "cine.nii.gz")
    assert cine.shape == labels.shape and numpy.allclose(cine.affine, labels.affine, atol=1e-6)
    # A package of less than every surface says what it lacks, and who would hold it.
    folder, small = new_folder("export_palpation"), WORK / "export_palpation.beatlas"
    shutil.copytree(STUDY, folder)
    beatlas("pack", "--study", folder, "-o", small, "--scene", "palpation")
    said = beatlas("export", small, "--to", "obj", "-o", new_folder("export_none"), code=3).stderr
    assert "holds no surface" in said and "anatomy" in said, said
    assert not list((WORK / "export_none").glob("*")), "nothing half written"
    surfaces = new_folder("export_obj")
    beatlas("export", PACKAGE, "--to", "obj", "-o", surfaces)
    files = sorted(surfaces.glob("heart_*.obj"))
    assert len(files) == truth.shape[3]
    faces = [tuple(map(int, line.split()[1:])) for line in files[0].read_text().splitlines()
             if line.startswith("f ")]
    edges = {(f[i], f[(i + 1) % 3]) for f in faces for i in range(3)}
    assert len(edges) == 3 * len(faces) and all((b, a) in edges for a, b in edges)
    both = new_folder("export_study")
    beatlas("export", STUDY, "--to", "nifti", "-o", both)
    assert digest(both / "labels.nii.gz") == digest(out / "labels.nii.gz")
    whole = nibabel.load(both / "cine.nii.gz")
    stack = nibabel.load(STUDY / "exam" / "stack.nii.gz").get_fdata()
    assert numpy.array_equal(whole.get_fdata(), stack)
    # A package's images differ from the source's by about their noise; within the heart, where
    # more stands out of it, by no more than half as much again as near it (which `info` says).
    told = json.loads(beatlas("info", PACKAGE, "--json").stdout)["volume"]
    error = (cine.get_fdata() - stack)[a > 0]
    assert numpy.sqrt((error ** 2).mean()) < 1.5 * told["rms_error"], told
    assert 0.5 * told["noise"] < told["rms_error"] < 1.2 * told["noise"], told
    assert abs(error.mean()) < 0.05 * told["noise"], error.mean()
    figures = json.loads((STUDY / "pack" / "volume.json").read_text())
    assert figures == {name: told[name] for name in figures} and figures["psnr_db"] > 20


def workspace_to_metres(told):
    """+x the patient's left, +y the head, +z the front; as glTF has it."""
    lps_from_workspace = numpy.linalg.inv(numpy.reshape(told["workspace_from_lps"], (4, 4)))
    turn = numpy.array([[1, 0, 0], [0, 0, 1], [0, -1, 0]])
    return lambda points: 1e-3 * (nibabel.affines.apply_affine(lps_from_workspace, points) @ turn.T)


def formats():
    """What VTK reads of glTF as it plays it, and of OBJ: the vertices of every phase."""
    import vtk
    from vtk.util.numpy_support import vtk_to_numpy
    out = new_folder("formats")
    for kind in ("glb", "obj", "vdb"):
        beatlas("export", PACKAGE, "--to", kind, "-o", out)
    told = json.loads(beatlas("info", PACKAGE, "--json").stdout)
    names = [entry["name"] for entry in told["structures"]]
    assert sorted(file.name for file in out.glob("*.vdb")) == sorted(f"{n}.vdb" for n in names)
    phases, metres = told["phases"], workspace_to_metres(told)

    def of_obj(name, phase):
        reader = vtk.vtkOBJReader()
        reader.SetFileName(str(out / f"{name}_{phase:03}.obj"))
        reader.Update()
        return vtk_to_numpy(reader.GetOutput().GetPoints().GetData()).astype(float)

    reader = vtk.vtkGLTFReader()
    reader.SetFileName(str(out / "heart.glb"))
    reader.ApplyDeformationsToGeometryOn()
    reader.UpdateInformation()
    assert reader.GetNumberOfAnimations() == 1
    assert abs(reader.GetAnimationDuration(0) - told["rr_interval_s"]) < 1e-6
    reader.EnableAnimation(0)

    def of_gltf(beats):
        reader.UpdateTimeStep(beats * told["rr_interval_s"])
        found, walk = [], reader.GetOutput().NewIterator()
        walk.InitTraversal()
        while not walk.IsDoneWithTraversal():
            found.append(vtk_to_numpy(walk.GetCurrentDataObject().GetPoints().GetData()))
            walk.GoToNextItem()
        assert len(found) == len(names)
        return dict(zip(names, found))

    key = {(n, p): metres(of_obj(n, p)) for n in names for p in range(phases)}
    # A micrometre: floats near 0.3 m are 3e-8 m apart; a package's own step is 10 micrometres.
    for phase in range(phases):
        now, between = of_gltf(phase / phases), of_gltf((phase + 0.5) / phases)
        for name in names:
            here, after = key[name, phase], key[name, (phase + 1) % phases]
            assert abs(now[name] - here).max() < 1e-6, (name, phase, abs(now[name] - here).max())
            assert abs(between[name] - (here + after) / 2).max() < 1e-6, (name, phase)
    assert max(abs(key["heart", p] - key["heart", 0]).max() for p in range(phases)) > 2e-3, "beats"
    # A palpation package holds the heart's distances, and of surfaces the LV's endocardium alone.
    folder, small = new_folder("formats_palpation"), WORK / "formats.beatlas"
    shutil.copytree(STUDY, folder)
    beatlas("pack", "--study", folder, "-o", small, "--scene", "palpation")
    beatlas("export", small, "--to", "vdb", "-o", new_folder("formats_small"))
    assert [file.name for file in (WORK / "formats_small").iterdir()] == ["heart.vdb"]
    said = beatlas("export", small, "--to", "glb", "-o", WORK / "formats_none", code=3).stderr
    assert "holds no surface" in said and "anatomy" in said, said


def validate():
    schema = json.loads((pathlib.Path(__file__).parents[2] / "schemas" /
                         "validate.schema.json").read_text())
    checks = json.loads(beatlas("validate", PACKAGE, "--json").stdout)
    jsonschema.validate(checks, schema)
    assert checks["passed"] and len(checks["checks"]) >= 8, checks
    truth = WORK / "phantom"
    # Without a word: held to what is promised of such images; what is promised of coverage is out of their reach.
    plain = json.loads(beatlas("validate", PACKAGE, "--truth", truth, "--json").stdout)
    jsonschema.validate(plain, schema)
    assert plain["passed"] and plain["held_to"] == "small", plain["failures"]
    strict = json.loads(beatlas("validate", PACKAGE, "--truth", truth, "--limits", "coverage", "--json", code=4).stdout)
    assert strict["held_to"] == "coverage" and any(
        failure.startswith("rv_blood: mean_mm") and "--limits coverage" in failure
        for failure in strict["failures"]), strict["failures"]
    told = beatlas("validate", PACKAGE, "--truth", truth, "--limits", "none").stdout
    assert "held to" not in told and told.endswith("passed\n"), told
    # Limits: by option, by recipe, of one structure; a breach tells figure and limit.
    recipe = WORK / "limits.json"
    recipe.write_text(json.dumps({"validate": {
        "max_rms_mm": 3, "structures": {"lv_blood": {"max_rms_mm": 1e-3}}}}))
    report = json.loads(beatlas("validate", PACKAGE, "--truth", truth, "--recipe", recipe, "--json",
                                "--max-force-mean-n", 1e-6, code=4).stdout)
    jsonschema.validate(report, schema)
    assert report["held_to"] == "none", "limits of one's own stand alone"
    structures = {entry["name"]: entry for entry in report["structures"]}
    assert set(structures) == {"heart", "lv_blood", "rv_blood", "lv_myocardium"}, set(structures)
    # Less than a pixel of the prior (the heart's outside, where the RV's wall is not seen, than that wall); a
    # base that moves at 100 mm/s.
    for name, entry in structures.items():
        assert len(entry["phases"]) == PHASES, (name, len(entry["phases"]))
        for phase in entry["phases"]:
            assert phase["mean_mm"] <= phase["rms_mm"] <= phase["hausdorff_mm"] and phase["rms_mm"] < (
                3 if name == "heart" else 2), phase
            assert 0 < phase["normal_mean_deg"] <= phase["normal_p95_deg"] < (60 if name == "heart" else 45), phase
            assert 0 < phase["velocity_mean_mm_s"] <= phase["velocity_p95_mm_s"] < 150, phase
            assert ("wall_thickness" in phase) == (name == "lv_myocardium"), name
    for phase in structures["lv_myocardium"]["phases"]:
        wall = phase["wall_thickness"]
        assert wall["points"] > 100 and wall["missing"] <= 0.05 * wall["points"], wall
        assert 6 < wall["true_mean_mm"] < 15 and wall["mean_mm"] < 1.5, wall
    # The wall at the surfaces' own vertices; names are right but along borders. An axis that is 4 degrees off moves
    # the two borders along it by 1.3 mm of 30 in the mean, 4 % of names each, and those around it by 2 of 60 degrees.
    for name in ("lv_blood", "lv_myocardium"):
        of_map = structures[name]["map"]
        assert of_map["points"] > 2000 and of_map["missing"] <= 0.01 * of_map["points"], of_map
        assert 0 < of_map["thickness_mean_mm"] < 1 and of_map["thickness_p95_mm"] < 3.5, of_map
        assert of_map["named"] > 500 and of_map["segments_percent"] > 90, of_map
    assert "map" not in structures["heart"]
    force = report["force"]
    assert force["structure"] == "heart" and force["contact_ticks"] > 1000, force
    assert 0 < force["mean_n"] <= force["rms_n"] <= force["max_n"] < 2.4, "two forces of 8 mm depth"
    assert force["mean_n"] < 0.25 and force["contact_differs_percent"] < 15, force
    failures = report["failures"]
    assert not report["passed"] and len(failures) == len(structures["lv_blood"]["phases"]) + 1, failures
    of_phase_3 = next(failure for failure in failures if "lv_blood in phase 3" in failure)
    assert "rms_mm is " in of_phase_3 and "the limit of 0.001" in of_phase_3, failures
    assert any("force of heart: mean_n is" in failure and "beyond the limit of 1e-06" in failure
               for failure in failures), failures
    # A limit of the command replaces the recipe's; the force of another structure.
    table = beatlas("validate", PACKAGE, "--truth", truth, "--recipe", recipe, "--max-rms-mm", 3,
                    "--force-structure", "lv_blood").stdout
    assert all(len(line) <= 100 for line in table.splitlines()), table
    assert "force of lv_blood" in table and table.endswith("passed\n"), table
    # The same heart with other noise is another phantom, by what its images carry alone.
    other = new_folder("other_noise")
    beatlas("phantom", "-o", other, "--preset", "small", "--without", "all", "--seed", 7, "--format", "nifti")
    said = beatlas("validate", PACKAGE, "--truth", other, code=3).stderr
    assert "another phantom" in said and "identity" in said, said
    coarse = WORK / "other_noise.json"
    coarse.write_text(json.dumps({"register": {"shape_mm": 2}, "field": {"voxel_mm": 3}, "mesh": {"edge_mm": 5}}))
    beatlas("build", other / "cine.nii.gz", "-o", WORK / "other_noise.beatlas", "--recipe", coarse)
    beatlas("validate", WORK / "other_noise.beatlas", "--truth", other, "--limits", "none")
    beatlas("validate", WORK / "other_noise.beatlas", "--truth", truth, code=3)
    damaged = WORK / "damaged.beatlas"
    data = bytearray(PACKAGE.read_bytes())
    data[len(data) // 2] ^= 1
    damaged.write_bytes(data)
    beatlas("validate", damaged, code=3)


def quality():
    """Below what the recipe demands: exit code 4, no package, the old one untouched."""
    recipe = WORK / "strict.json"
    recipe.write_text('{"quality": {"max_volume_gap_percent": 0.1}, "field": {"voxel_mm": 4, "outer_mm": 8}}')
    out = WORK / "strict.beatlas"
    shutil.copy(PACKAGE, out)
    said = beatlas("build", EXAM, "-o", out, "--recipe", recipe, code=4).stderr
    assert "max_volume_gap_percent" in said, said
    expect_same(PACKAGE, out)


def vertices_of_ply(file):
    """Offset and positions of vertices that are three floats each."""
    data = file.read_bytes()
    first = data.index(b"end_header\n") + len(b"end_header\n")
    count = int(re.search(rb"element vertex (\d+)", data).group(1))
    return data, first, numpy.frombuffer(data, "<f4", 3 * count, first).reshape(count, 3)


def corrections():
    """Surfaces moved by hand in a study reach the package where they are; a broken one is refused by its name."""
    folder = new_folder("corrections")
    shutil.copytree(STUDY, folder)
    moved = []
    for mesh in sorted((folder / "mesh").glob("lv_blood_*.ply")):
        data, first, points = vertices_of_ply(mesh)
        moved.append(points + numpy.float32([0.8, 0, 0]))  # into the muscle, whose surface makes room
        mesh.write_bytes(data[:first] + moved[-1].tobytes() + data[first + 4 * points.size:])
    beatlas("pack", "--study", folder, "-o", WORK / "corrected.beatlas")
    out = new_folder("corrected_obj")
    beatlas("export", WORK / "corrected.beatlas", "--to", "obj", "-o", out)
    for phase in (0, len(moved) // 2):
        lines = (out / f"lv_blood_{phase:03}.obj").read_text().splitlines()
        shown = numpy.array([line.split()[1:4] for line in lines if line.startswith("v ")], float)
        assert shown.shape == moved[phase].shape
        off = max(numpy.abs(moved[phase] - x).max(axis=1).min() for x in shown[::20])
        assert off < 0.015, f"a vertex of the package lies {off} mm from where it was put"
    mesh = folder / "mesh" / "heart_000.ply"
    mesh.write_bytes(mesh.read_bytes()[:-5])
    said = beatlas("pack", "--study", folder, "-o", WORK / "corrected.beatlas", code=3).stderr
    assert "heart_000.ply" in said, said


if __name__ == "__main__":
    globals()[sys.argv[3]]()
