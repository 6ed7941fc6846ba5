"""A program that overflows an int is ended there: sanitizer_finding.py PROGRAM"""
import subprocess
import sys

done = subprocess.run(sys.argv[1], capture_output=True, text=True)
if done.returncode == 0 or "runtime error: signed integer overflow" not in done.stderr or done.stdout:
    sys.exit(f"exit code {done.returncode}, stdout: {done.stdout}stderr: {done.stderr}")
