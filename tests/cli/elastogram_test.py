"""Puts an image of stiffness on an atlas's wall and presses there:
elastogram_test.py BEATLAS BEATLAS_PLAY MAKE_SAMPLE_PACKAGE
"""
import array
import csv
import json
import pathlib
import sys
import tempfile

sys.dont_write_bytecode = True
from checks import check, refused, run  # noqa: E402

BEATLAS, PLAY, MAKE = sys.argv[1:4]


def write_image(file, value, origin=-300, frames=1):
    """NRRD, 30 voxels of 20 mm along each axis of the patient's frame."""
    sizes = "30 30 30" + (f" {frames}" if frames > 1 else "")
    none = " none" if frames > 1 else ""
    header = (f"NRRD0004\ntype: float\ndimension: {4 if frames > 1 else 3}\n"
              f"space: left-posterior-superior\nsizes: {sizes}\n"
              f"space directions: (20,0,0) (0,20,0) (0,0,20){none}\n"
              f"space origin: ({origin},{origin},{origin})\nencoding: raw\nendian: little\n\n")
    file.write_bytes(header.encode() + array.array("f", [value] * (27000 * frames)).tobytes())


with tempfile.TemporaryDirectory() as name:
    folder = pathlib.Path(name)
    package = folder / "heart.beatlas"
    check(run(MAKE, package, "palpation").returncode == 0, "no package")
    image, table = folder / "stiffness.nrrd", folder / "stiffness.csv"

    # 4 kPa of shear are 12 of elasticity, everywhere.
    write_image(image, 4000)
    words = [BEATLAS, "elastogram", package, image, "-o", table]
    done = run(*words, "--unit", "pa", "--modulus", "shear", "--json")
    check(done.returncode == 0, done.stderr)
    told = json.loads(done.stdout)
    check(0.7 * told["vertices"] < told["measured"] <= told["vertices"], told)
    check(all(abs(value - 12) < 1e-4 for value in told["kpa"].values()), told)
    rows = list(csv.DictReader(table.open()))
    check(len(rows) == told["measured"] and all(abs(float(row["kpa"]) - 12) < 1e-4 for row in rows), rows[:3])
    check("12 kPa" in run(*words, "--unit", "pa", "--modulus", "shear").stdout, "no text")

    # Twice as stiff as healthy is felt: a press at the same place meets more force.
    forces = []
    for healthy in (12, 6):
        parameters = folder / "parameters.json"
        parameters.write_text(json.dumps({"regions": [{"measured": table.name, "healthy_kpa": healthy}]}))
        done = run(PLAY, package, "--headless", "--press", folder / "press", "--parameters", parameters, "--json")
        check(done.returncode == 0, done.stderr)
        atlas = json.loads(done.stdout)["atlas"]
        check(abs(atlas["wall"]["stiffness_ratio"] - 12 / healthy) < 1e-3, atlas["wall"])
        forces.append(atlas["largest_force_n"])
    check(forces[1] > 1.2 * forces[0], forces)

    before = table.read_bytes()
    refused(run(*words), 3, "--unit kpa or pa")
    write_image(image, 4000, origin=4000)
    refused(run(*words, "--unit", "pa"), 3, "is it an image of this heart")
    write_image(image, 4000, frames=2)
    refused(run(*words, "--unit", "pa"), 3, "2 images one after another")
    image.write_bytes(b"no image")
    refused(run(*words), 3, "stiffness.nrrd")
    refused(run(BEATLAS, "elastogram", folder / "none.beatlas", image, "-o", table), 3, "none.beatlas")
    check(table.read_bytes() == before, "what was refused wrote a table")
    write_image(image, 4000)
    refused(run(BEATLAS, "elastogram", package, image, "-o", folder / "none" / "map.csv", "--unit", "pa"), 5, "map.csv")
print("elastogram: as it should be")
