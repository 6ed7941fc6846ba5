"""Ours beside paper A's method and beside cheaper interpolation, on the phantom small."""
import json

# (interpolation in space, in time) of the sweep's runs that README.md states.
ROWS = {("cubic", "cubic"): "ours: cubic in space and time", ("cubic", "linear"): "linear in time",
        ("trilinear", "linear"): "trilinear, linear in time", ("nearest", "linear"): "nearest voxel, linear in time",
        "published": "paper A: voxels, force linear in time"}


def measure(tools):
    tools.run("beatlas", "bench", "-o", "bench", "--only", "published,interpolation")
    values = {}
    for run in json.loads((tools.folder / "bench" / "bench.json").read_text())["runs"]:
        knobs = run["values"]
        row = "published" if run["kind"] == "published" else (knobs.get("/query/space"), knobs.get("/query/time"))
        if row not in ROWS or run["kind"] == "surface":
            continue
        values.setdefault(ROWS[row], {})[run["sweep"]] = {
            "mean_mm": run["errors"]["heart"]["mean_mm"],
            "frames_mean_mm": run["errors"]["heart"]["frames_mean_mm"], "force_mean_n": run["force"]["mean_n"]}
    return values


def text(values):
    lines = ["| heart of `small`, mean error | from the exact shape mm | in the frames mm | N | from images mm | N |",
             "|---|---|---|---|---|---|"]
    for called in ROWS.values():
        exact, images = (values.get(called, {}).get(sweep) for sweep in ("exact", "images"))
        cells = [f"{exact['mean_mm']:.3f} | {exact['frames_mean_mm']:.3f} | {exact['force_mean_n']:.3f}" if exact
                 else " | | ",
                 f"{images['mean_mm']:.3f} | {images['force_mean_n']:.3f}" if images else " | "]
        lines.append(f"| {called} | {' | '.join(cells)} |")
    return "\n".join(lines)
