"""An alarm is a warning of the segmentation where the report's verdict counts it, and else a place to look at in both.

alarms_test.py BEATLAS SEED: segments a drawn heart, of whose alarms the prior bears out some and some not.
"""
import json
import pathlib
import re
import subprocess
import sys
import tempfile


def run(beatlas, *words):
    done = subprocess.run([beatlas, *map(str, words)], capture_output=True, text=True, check=False)
    if done.returncode:
        sys.exit(f"alarms_test: beatlas {words[0]} ended with {done.returncode}: {done.stderr}")
    return done


def main(beatlas, seed):
    with tempfile.TemporaryDirectory() as folder:
        drawn, study = pathlib.Path(folder, "draw"), pathlib.Path(folder, "study")
        run(beatlas, "phantom", "--draw", seed, "-o", drawn, "--format", "nifti", "--most-voxels", 2000000)
        run(beatlas, "import", drawn / "cine.nii.gz", "--study", study)
        lines = run(beatlas, "segment", "--study", study, "-v").stderr.splitlines()
        alarms = json.loads((study / "segment" / "segment.json").read_text())["alarms"]
        report = json.loads(run(beatlas, "report", study, "--json").stdout)
    told = [line for line in lines if "look there for a leak" in line]
    places = [line for line in told if "a place to look at, where labels are as expected: " in line]
    warnings = [line for line in told if line.startswith("beatlas: warning: ")]
    print("\n".join(told))
    assert warnings and places and len(warnings) + len(places) == len(told) == len(alarms), (told, alarms)
    [reason] = [reason["sentence"] for reason in report["reasons"] if reason["id"] == "leaks"]
    counted = re.search(r"leaked: (\d+) alarms? .*; (\d+) places? to look at", reason)
    assert counted and [int(n) for n in counted.groups()] == [len(warnings), len(places)], reason
    # The report leads to each of them.
    assert sum(place["kind"] == "leak" for place in report["places"]) == len(alarms), report["places"]
    return 0


sys.exit(main(*sys.argv[1:]))
