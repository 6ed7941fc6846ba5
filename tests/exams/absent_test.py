"""Tests of real exams are skipped, and counted so, where there are none, and fail where one of them is missing:
absent_test.py CTEST BUILD_FOLDER
"""
import os
import pathlib
import re
import subprocess
import sys
import tempfile

CTEST, BUILD = sys.argv[1], pathlib.Path(sys.argv[2])
# The folder of tests, which of its tests, and how many these are at least.
TESTS = (("tests/unit/segment", r"^RealExam\.", 2), ("tests/unit/ingest", r"^RealExam\.", 2),
         ("tests/import", r"^import\.cine_exam\.whole_folder$", 1),
         ("tests/exams", r"^exams\.(held|seeds|one_seed|varied)", 11))


def states(folder, pattern, data):
    """What ctest says of each test, where the real exams' folder is `data`."""
    done = subprocess.run([CTEST, "--test-dir", BUILD / folder, "-R", pattern], capture_output=True, text=True,
                          env={**os.environ, "BEATLAS_SHARED_DATA": str(data)})
    return dict(re.findall(r"^ *\d+/\d+ Test +#\d+: (\S+) [. *]*(Passed|Skipped|Failed|Not Run)", done.stdout,
                           re.MULTILINE)), done.stdout


with tempfile.TemporaryDirectory(prefix="beatlas-absent-") as name:
    nothing = pathlib.Path(name)
    for folder, pattern, least in TESTS:
        told, said = states(folder, pattern, nothing)
        assert len(told) >= least, f"{folder}: {len(told)} tests of real exams, {least} at least are wanted\n{said}"
        assert set(told.values()) == {"Skipped"}, said
    # A list of exams without the exams: nothing is skipped silently, and nothing passes.
    (nothing / "exams.json").write_text("{}")
    for folder, pattern, least in TESTS:
        told, said = states(folder, pattern, nothing)
        assert len(told) >= least and set(told.values()) == {"Failed"}, said
