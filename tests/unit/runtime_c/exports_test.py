"""The library exports the functions of its C header, all of them and nothing else:
exports_test.py LIBRARY HEADER
"""
import pathlib
import re
import subprocess
import sys


def main():
    library, header = sys.argv[1], pathlib.Path(sys.argv[2]).read_text()
    declared = set(re.findall(r"^BEATLAS_API [^;(]*?\b(beatlas_\w+)\(", header, re.MULTILINE))
    assert len(declared) == header.count("BEATLAS_API ") - header.count("#define BEATLAS_API "), (
        f"a declaration of the header was not read; read were {sorted(declared)}")
    listed = subprocess.run(["nm", "-D", "--defined-only", library], capture_output=True, text=True)
    assert listed.returncode == 0, listed.stderr
    exported = {line.split()[-1] for line in listed.stdout.splitlines()}
    problems = [f"{name} is declared and not exported" for name in sorted(declared - exported)]
    problems += [f"{name} is exported and not declared" for name in sorted(exported - declared)]
    if not declared or problems:
        sys.exit("\n".join(problems) or "the header declares nothing")


main()
