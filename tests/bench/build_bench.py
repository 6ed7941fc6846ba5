"""Time per stage and peak memory of a whole build of a phantom, from DICOM to package.

    python3 tests/bench/build_bench.py build/release/bin/beatlas [--preset adult] [--runs 3]

Each run is a process of its own; wall time, CPU time and their medians over the runs. The machine's
own speed moves between runs, so compare ratios within one call.
"""

import argparse
import json
import os
import pathlib
import statistics
import subprocess
import tempfile


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("beatlas", help="the built command")
    parser.add_argument("--preset", default="adult", help="phantom to build")
    parser.add_argument("--runs", type=int, default=3)
    parser.add_argument("--threads", default=[0], type=int, nargs="+", help="0 = all cores")
    arguments = parser.parse_args()

    with tempfile.TemporaryDirectory() as folder:
        work = pathlib.Path(folder)
        subprocess.run([arguments.beatlas, "phantom", "--preset", arguments.preset, "--without", "all", "--format",
                        "dicom", "-o", work / "phantom"], check=True, stdout=subprocess.DEVNULL)
        print(f"preset {arguments.preset}, {os.cpu_count()} cores, {arguments.runs} runs, medians")
        for threads in arguments.threads:
            report([timing(arguments.beatlas, work, threads) for _ in range(arguments.runs)])
        print(f"package {(work / 'heart.beatlas').stat().st_size / 1e6:.2f} MB")


def timing(beatlas, work, threads):
    subprocess.run([beatlas, "build", work / "phantom", "-o", work / "heart.beatlas", "--threads",
                    str(threads), "--timing", work / "timing.json"], check=True,
                   stderr=subprocess.DEVNULL)
    return json.loads((work / "timing.json").read_text())


def report(runs):
    print(f"\nthreads {runs[0]['threads'] or 'all'}")
    print(f"{'stage':<12}{'wall s':>9}{'cpu s':>9}")
    for index, stage in enumerate(runs[0]["stages"]):
        wall = statistics.median(run["stages"][index]["wall_s"] for run in runs)
        cpu = statistics.median(run["stages"][index]["cpu_s"] for run in runs)
        print(f"{stage['name']:<12}{wall:9.2f}{cpu:9.2f}")
    total = statistics.median(run["wall_s"] for run in runs)
    cpu = statistics.median(sum(stage["cpu_s"] for stage in run["stages"]) for run in runs)
    print(f"{'total':<12}{total:9.2f}{cpu:9.2f}")
    print(f"peak memory {statistics.median(run['peak_memory_mb'] for run in runs):.0f} MB")


if __name__ == "__main__":
    main()
