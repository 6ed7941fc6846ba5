"""What the tests of commands beside this one have in common."""
import subprocess
import sys


def run(*words, environment=None):
    return subprocess.run([*map(str, words)], capture_output=True, text=True, env=environment)


def check(holds, told):
    if not holds:
        sys.exit(str(told))


def refused(done, code, words):
    """Refused with that exit code by one sentence that holds `words`."""
    check(done.returncode == code and words in done.stderr and "\n" not in done.stderr.strip(),
          f"expected exit {code} and '{words}', got {done.returncode}: {done.stderr}")
