"""What docs/promises.md says of a phantom from its images is kept: promises_test.py BEATLAS PRESET

The phantom is imaged, imported, segmented, packed, opened again and compared with the truth, with no option: `beatlas
validate --truth` holds each preset to 1.3 times its promise.
"""
import json
import pathlib
import subprocess
import sys
import tempfile

PROGRAM, PRESET = sys.argv[1], sys.argv[2]


def beatlas(*words):
    done = subprocess.run([PROGRAM, *map(str, words)], capture_output=True, text=True, check=False)
    if done.returncode:
        sys.exit(f"beatlas {' '.join(map(str, words))}: exit {done.returncode}\n{done.stdout}{done.stderr}")
    return done.stdout


with tempfile.TemporaryDirectory(prefix="beatlas-promises-") as folder:
    made, package = pathlib.Path(folder) / "phantom", pathlib.Path(folder) / "heart.beatlas"
    beatlas("phantom", "--preset", PRESET, "-o", made)
    beatlas("build", made / "dicom", "-o", package)
    told = json.loads(beatlas("validate", package, "--truth", made, "--json"))
    assert told["held_to"] and told["passed"], told
    print(f"{PRESET} is held to {told['held_to']}")
