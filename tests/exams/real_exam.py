"""Where the tests of real exams find them."""
import json
import os
import pathlib
import sys

SKIPPED = 77


def real_exam(root, name):
    """Folder of the real exams beside the sources at `root`, and what their list says of `name`. Ends the test as
    skipped where they are not on the machine."""
    data = pathlib.Path(os.environ.get("BEATLAS_SHARED_DATA") or root.parent / "shared" / "data")
    if not (data / "exams.json").exists():
        print(f"skipped: the real exams of {data} are not on this machine")
        sys.exit(SKIPPED)
    return data, json.loads((data / "exams.json").read_text())[name]
