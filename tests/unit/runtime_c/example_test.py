"""The C example presses into a heart and says how hard, and ends with an error where it cannot:
example_test.py EXAMPLE PACKAGE
"""
import re
import subprocess
import sys

EXAMPLE, PACKAGE = sys.argv[1:3]


def run(*words):
    return subprocess.run([EXAMPLE, *words], capture_output=True, text=True, timeout=50)


done = run(PACKAGE)
assert done.returncode == 0, done
assert not done.stderr, done.stderr
last = re.fullmatch(r"2000 ticks, at most (\d+\.\d\d) N", done.stdout.splitlines()[-1])
# Twelve millimetres deep at 150 N/m; the safety stage lets no more than 3 N through.
assert last and 1 < float(last.group(1)) <= 3, done.stdout

done = run()
assert done.returncode == 2 and "usage" in done.stderr, done
done = run(f"{PACKAGE}.none")
assert done.returncode == 1 and f"{PACKAGE}.none" in done.stderr, done
