"""A quick sweep of some knobs: its files, and that errors behave: bench_test.py BEATLAS SOURCE_FOLDER"""
import json
import pathlib
import subprocess
import sys
import tempfile
import xml.etree.ElementTree

import jsonschema

PROGRAM, SOURCE = sys.argv[1], pathlib.Path(sys.argv[2])

with tempfile.TemporaryDirectory(prefix="beatlas-bench-") as folder:
    out = pathlib.Path(folder) / "out"
    done = subprocess.run([PROGRAM, "bench", "-o", str(out), "--quick", "--repeats", "1",
                           "--only", "published,voxel,interpolation,level-of-detail,volume-step"],
                          capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert not done.stderr, f"a pipe stays quiet: {done.stderr}"
    report = json.loads((out / "bench.json").read_text())
    jsonschema.validate(report, json.loads((SOURCE / "schemas" / "bench.schema.json").read_text()))
    assert done.stdout == (out / "bench.md").read_text()
    for table in done.stdout.split("\n## ")[1:]:
        cells = {line.count("|") for line in table.splitlines() if line.startswith("|")}
        assert len(cells) == 1, f"rows and heads of a table differ: {cells}\n{table}"
    left = sorted(p.name for p in out.iterdir())
    plots = [f"bench_{s}_{w}.svg" for s in ("exact", "images") for w in ("build", "bytes", "query")]
    assert left == sorted(["bench.json", "bench.md", *plots]), left
    for plot in plots:
        assert xml.etree.ElementTree.parse(out / plot).getroot().tag.endswith("svg")


def runs(sweep, knob):
    return {tuple(run["values"].values()): run for run in report["runs"]
            if run["sweep"] == sweep and run["knob"] == knob}


def mean(run, structure="heart"):
    return run["errors"][structure]["mean_mm"]


voxel, modes = runs("exact", "voxel"), runs("exact", "interpolation")
fine, coarse = voxel[(1.5,)], voxel[(3.0,)]
for structure in ("heart", "lv_blood", "rv_blood"):
    assert mean(fine, structure) < mean(coarse, structure), structure
    # Ten phases cost more than 1.5 mm voxels do; in the frames the voxel alone tells.
    assert (2 * fine["errors"][structure]["frames_mean_mm"]
            < coarse["errors"][structure]["frames_mean_mm"]), structure
assert fine["package_bytes"] > coarse["package_bytes"]
assert fine["force"]["mean_n"] < coarse["force"]["mean_n"]
assert fine["default"] and not coarse["default"]
# With time exactly as it is, each spatial mode is nearer than the one before; so is each in time.
assert (mean(modes["cubic", "cubic"]) < mean(modes["trilinear", "cubic"])
        < mean(modes["nearest", "cubic"]))
assert mean(modes["cubic", "cubic"]) < mean(modes["cubic", "linear"])
assert mean(modes["cubic", "cubic"]) == mean(fine), "the default is one and the same run"
# What the images cost is in every figure of their sweep; paper A's voxels are worse than all.
assert mean(runs("images", "voxel")[(1.5,)]) > mean(fine)
published = runs("exact", "published")[()]
assert mean(published) > mean(modes["trilinear", "linear"])
assert published["force"]["p95_n"] > modes["cubic", "cubic"]["force"]["p95_n"]
# Some run is on each front, and none that another beats in both.
exact = [run for run in report["runs"] if run["sweep"] == "exact" and run["kind"] in ("field", "published")]
for run in exact:
    beaten = any(mean(o) < mean(run) and o["package_bytes"] < run["package_bytes"] for o in exact)
    assert not (beaten and "bytes" in run["front"]), run["values"]
for name in ("bytes", "query", "build"):
    assert any(name in run["front"] for run in exact), name
# A coarser level of detail is farther off and smaller; a coarser volume likewise, and what it leaves out by default is
# noise.
level, volume = runs("exact", "level-of-detail"), runs("images", "volume-step")
assert mean(level[(2.0,)]) < mean(level[(4.0,)]) and mean(level[(2.0,)], "lv_blood") < mean(level[(4.0,)], "lv_blood")
assert level[(2.0,)]["package_bytes"] > 1.5 * level[(4.0,)]["package_bytes"]
assert "level" in level[(4.0,)]["stage_s"] and level[(2.0,)]["default"]
assert volume[(2.0,)]["volume"]["of_noise"] < 0.95 < volume[(8.0,)]["volume"]["of_noise"]
assert volume[(2.0,)]["package_bytes"] > 1.5 * volume[(8.0,)]["package_bytes"] and not volume[(2.0,)]["errors"]
