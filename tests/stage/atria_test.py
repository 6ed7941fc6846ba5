"""A heart with atria and aorta, from images to the package: atria_test.py BEATLAS WORK_FOLDER

WORK_FOLDER is that of stage_test.py. A structure that is in the package is where it should be, one that
could not be told is said; scenes hold what they need and nothing more.
"""
import json
import zipfile

import nibabel
import numpy

from stage_test import WORK, beatlas, new_folder

BEYOND = {"la_blood": 5, "ra_blood": 6, "aorta": 7}


def shown(package):
    info = json.loads(beatlas("info", package, "--json").stdout)
    surfaces = {item["structure"] for item in info["items"] if item["kind"] == "surface"}
    fields = {item["structure"] for item in info["items"] if item["kind"] == "field"}
    volumes = {entry["name"]: numpy.array(entry["volume_ml"]) for entry in info["structures"]}
    return surfaces, fields, volumes


def main():
    folder = new_folder("atria")
    images, study = folder / "cine.nii.gz", folder / "exam.study"
    beatlas("phantom", "-o", folder, "--preset", "small", "--format", "nifti", "--phases", 5)
    recipe = folder / "recipe.json"
    recipe.write_text(json.dumps({"register": {"shape_mm": 2}, "field": {"voxel_mm": 2}, "mesh": {"edge_mm": 3}}))
    full = folder / "full.beatlas"
    said = beatlas("build", images, "-o", full, "--study", study, "--recipe", recipe).stderr
    surfaces, fields, volumes = shown(full)
    assert not fields & set(BEYOND), fields
    told = {name for name in BEYOND if f"warning: {name} " in said}
    assert "la_blood" in surfaces and set(BEYOND) - surfaces <= told, (surfaces, said)
    truth = nibabel.load(folder / "truth_labels.nii.gz")
    voxel_ml = abs(numpy.linalg.det(truth.affine[:3, :3])) * 1e-3
    labels = numpy.asarray(truth.dataobj)
    made = numpy.asarray(nibabel.load(study / "segment" / "labels.nii.gz").dataobj)
    for name, label in BEYOND.items():
        if name not in surfaces:
            continue
        true_ml = (labels == label).sum(axis=(0, 1, 2)) * voxel_ml
        off = abs(volumes[name] / true_ml - 1).max()
        same = 2 * ((labels == label) & (made == label)).sum() / ((labels == label).sum() + (made == label).sum())
        print(f"{name}: volume off by {100 * off:.1f} % at most, Dice {same:.3f}")
        # Atria end where valves and veins are, which no edge shows.
        assert off < 0.3 and same > 0.8, (name, off, same)
    # Closed surfaces that enclose the volumes that are told and lie beside the ventricles'.
    checks = json.loads(beatlas("validate", full, "--json", code=None).stdout)["checks"]
    mine = [check for check in checks
            if check["structure"] in BEYOND or check["name"].removeprefix("crosses_").split("_level")[0] in BEYOND]
    assert len(mine) > 8 and all(check["passed"] for check in mine), [c for c in mine if not c["passed"]]

    # A scene that draws none of them goes without, from the segmentation on, or from this study.
    touch, packed = folder / "touch.beatlas", folder / "packed.beatlas"
    said = beatlas("build", images, "-o", touch, "--scene", "palpation", "--recipe", recipe, "-v").stderr
    surfaces, _, volumes = shown(touch)
    assert not (surfaces | set(volumes)) & set(BEYOND), (surfaces, volumes)
    assert "aorta" not in said, said
    beatlas("pack", "--study", study, "-o", packed, "--scene", "palpation")
    # The study's segmentation said more, of what this scene does not draw.
    payloads = [{name: archive.read(name) for name in archive.namelist() if name != "atlas.json"}
                for archive in map(zipfile.ZipFile, (touch, packed))]
    assert payloads[0] == payloads[1] and len(payloads[0]) > 3, [sorted(names) for names in payloads]


main()
