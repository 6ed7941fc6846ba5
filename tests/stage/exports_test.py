"""Every export of every scene of two hearts: exports_test.py BEATLAS WORK_FOLDER SAMPLES

The phantom with atria that atria_test.py built, packed for every scene there is by name or among the samples, and
the sample ventricle of key surfaces for those by name. An export works, or names what the package lacks and a scene
that holds it, which is then true.
"""
import json
import pathlib
import re
import subprocess
import sys

import nibabel
import numpy

from stage_test import WORK, beatlas, new_folder

SAMPLES = pathlib.Path(sys.argv[3])
KINDS = ("glb", "obj", "vdb", "nifti")
# Of labels by surfaces of 3 mm and by distances at 2 mm: both tell of the same zero.
LEAST_DICE = 0.97
LABELS = {"rv_blood": 1, "lv_myocardium": 2, "lv_blood": 3, "la_blood": 5, "ra_blood": 6, "aorta": 7}
# What there is to export of a scene's content; labels want every structure, as distances or as surfaces.
WORKS = {"palpation": {"vdb"}, "anatomy": {"glb", "obj", "nifti"}, "full": set(KINDS)}
LACKS = re.compile(r": holds no (field|surface) of (\w+); build it with --scene (palpation|anatomy|full)"
                   r"( or full)?\n$")


NAMED = {name: name for name in WORKS}


def sample_scenes():
    """Content of each, by its file."""
    out = {str(file): re.search(r'"content": "(\w+)"', file.read_text())[1]
           for file in sorted(SAMPLES.glob("scene_*.json"))}
    assert len(out) > 2, out
    return out


def files_of(folder):
    return sorted(file.name for file in folder.glob("*")) if folder.is_dir() else []


def labels_in(folder):
    return numpy.asarray(nibabel.load(folder / "labels.nii.gz").dataobj)


def expect_same_labels(a, b, structures):
    assert a.shape == b.shape
    for name in structures:
        here, there = ((x > 0) if name == "heart" else (x == LABELS[name]) for x in (a, b))
        dice = 2 * (here & there).sum() / (here.sum() + there.sum())
        print(f"{name}: Dice {dice:.4f}")
        assert dice > LEAST_DICE, (name, dice)


def exported(source, kind, code=None):
    folder = new_folder(f"{pathlib.Path(source).stem}_{kind}")
    return beatlas("export", source, "--to", kind, "-o", folder, code=code), folder


def expect_exports(heart, study, scenes):
    """SCENES: names or files, and the content of each."""
    packages, infos, held, labels = {}, {}, {}, {}
    for scene in scenes:
        packages[scene] = WORK / f"{heart}_{pathlib.Path(scene).stem}.beatlas"
        beatlas("pack", "--study", study, "-o", packages[scene], "--scene", scene)
        infos[scene] = json.loads(beatlas("info", packages[scene], "--json").stdout)
        held[scene] = [(item["kind"], item["structure"]) for item in infos[scene]["items"]]
    for scene, content in scenes.items():
        structures = [entry["name"] for entry in infos[scene]["structures"]]
        for kind in KINDS:
            done, folder = exported(packages[scene], kind)
            if kind not in WORKS[content]:
                assert done.returncode == 3 and not files_of(folder), (scene, kind, done.stderr)
                lacks = LACKS.search(done.stderr)
                assert lacks, (scene, kind, done.stderr)
                for way in filter(None, (lacks[3], (lacks[4] or "").removeprefix(" or "))):
                    assert (lacks[1], lacks[2]) in held[way], (done.stderr, way)
                continue
            assert done.returncode == 0, (scene, kind, done.stderr)
            expected = {
                "glb": ["heart.glb"],
                "obj": [f"{name}_{phase:03}.obj" for name in structures
                        for phase in range(infos[scene]["phases"])],
                "vdb": [f"{name}.vdb" for what, name in held[scene] if what == "field"],
                "nifti": ["cine.nii.gz"] * (content == "full") + ["labels.nii.gz"]}[kind]
            told = files_of(folder)
            # Tables of the labels' names may lie beside them.
            assert set(expected) <= set(told) and (kind == "nifti" or len(told) == len(expected)), (scene, told)
            if kind == "nifti":
                labels[content] = labels_in(folder)
    for kind in KINDS:
        done, folder = exported(study, kind, code=0)
        assert files_of(folder), kind
        if kind == "nifti":
            # Of the study's own distances, those of atria among them.
            labels["study"] = labels_in(folder)
    structures = [entry["name"] for entry in infos["full"]["structures"]]
    expect_same_labels(labels["full"], labels["study"], structures)
    expect_same_labels(labels["anatomy"], labels["study"], structures)
    return labels["full"]


def main():
    labels = expect_exports("phantom", WORK / "atria" / "exam.study", NAMED | sample_scenes())
    assert (labels == LABELS["la_blood"]).sum() > 1000, "or the test tries nothing"

    recipe = WORK / "exports.json"
    recipe.write_text(json.dumps({"field": {"voxel_mm": 2}, "mesh": {"edge_mm": 3},
                                  "quality": {"max_volume_gap_percent": 100}}))
    ventricle = new_folder("ventricle")
    subprocess.run(["/usr/bin/python3", "-B", SAMPLES / "make_ventricle.py", ventricle], check=True)
    told = json.loads((ventricle / "ventricle.json").read_text())
    told |= {"phases": 7, "contraction_phases": 3, "voxel_mm": 2}
    (ventricle / "ventricle.json").write_text(json.dumps(told))
    study = new_folder("ventricle.study")
    beatlas("import", "--surfaces", ventricle / "ventricle.json", "--study", study)
    beatlas("build", "--study", study, "-o", WORK / "ventricle_full.beatlas", "--recipe", recipe)
    expect_exports("ventricle", study, NAMED)


main()
