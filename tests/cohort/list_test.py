"""Lines of the cohort's list that look like options: list_test.py BEATLAS SOURCE_FOLDER

A line names a source, whatever it begins with, and no message names it back.
"""
import json
import os
import pathlib
import subprocess
import sys
import tempfile

PROGRAM, SOURCE = sys.argv[1], pathlib.Path(sys.argv[2])
TOOL = SOURCE / "scripts" / "cohort" / "cohort.py"
SURNAME = "Mustermann"

with tempfile.TemporaryDirectory(prefix="beatlas-list-") as work:
    work = pathlib.Path(work)
    cohort = work / "cohort"
    cohort.mkdir()
    subprocess.run([PROGRAM, "phantom", "-o", work / "p", "--preset", "small", "--phases", "4", "--without",
                    "all", "--format", "nifti"], check=True, capture_output=True)
    images = (work / "p" / "cine.nii.gz").read_bytes()
    # Relative to the cohort's folder; the second would print the help and end with 0. The last two
    # are no images.
    lines = [f"-{SURNAME}.nii.gz", "--help", f"--recipe={SURNAME}.nii.gz", f"-{SURNAME}", f"--{SURNAME}=("]
    for line in lines:
        (cohort / line).write_bytes(images if line.endswith(".nii.gz") else b"no image")
    (work / "list.txt").write_text("# a comment\n" + "".join(f"{line}\n" for line in lines))

    def import_of(number):
        exam = f"exam_{number:03d}"
        done = subprocess.run(
            ["/usr/bin/python3", "-B", TOOL, "stage", "import", exam, "--threads", "1"], cwd=cohort,
            capture_output=True, text=True,
            env=dict(os.environ, BEATLAS_COHORT_LIST=str(work / "list.txt"), BEATLAS_COHORT_PROGRAM=PROGRAM))
        assert SURNAME not in done.stdout + done.stderr, done.stderr
        for file in (cohort / exam).glob("*.json"):
            assert SURNAME not in file.read_text(), file.read_text()
        return done, cohort / exam

    for number in (1, 3):
        done, folder = import_of(number)
        assert done.returncode == 0, done.stderr
        assert (folder / "import.json").exists() and (folder / "study" / "exam").is_dir()
    for number in (2, 4, 5):
        done, folder = import_of(number)
        assert done.returncode == 1, done.stderr
        failure = json.loads((folder / "failure.json").read_text())
        # 3: bad input, which is what the file is; 2 would be wrong usage.
        assert failure["exit_code"] == 3 and "SOURCE" in failure["reason"], failure
        assert not (folder / "import.json").exists()
