#!/usr/bin/env python3
"""make_ventricle.py FOLDER [--own-triangles]: key surfaces of the virtual left ventricle of Tokuyasu
et al. (FIMH 2003): five from end-diastole to end-systole, of a dog of 25 kg at 110 beats a minute, for

    beatlas import --surfaces FOLDER/ventricle.json --study study
    beatlas build --study study -o ventricle.beatlas

The paper prints no shape. Here: a cavity of an ellipsoid of revolution cut at its base, 49.9 to 29.6 ml
(the trainer's natural beat), in a wall whose muscle keeps its volume. FOLDER/truth.json holds every
key's volumes in closed form. --own-triangles: other triangles in each key, in OBJ and STL.
"""
import json
import math
import pathlib
import struct
import sys

KEYS = 5
# Half axes across and along, height of the base plane, wall and wall at the apex [mm]; the shape of an
# adult's ventricle at end-diastole and end-systole.
ED = (27.0, 62.0, 30.0, 8.5, 6.0)
ES = (17.37, 51.22, 24.78, 13.38, 8.0)
EDV_ML, ESV_ML = 49.9, 29.6


def cut_ellipsoid_ml(a, c, b):
    return math.pi * a * a * (b - b**3 / (3 * c * c) + 2 * c / 3) / 1000


def shape(share):
    """Cavity and outside of a key: (a, c, b) each, the outside's muscle that of end-diastole."""
    def mixed(s):
        return [d + s * (e - d) for d, e in zip(ED, ES)]

    def at(s):
        a, c, b, wall, apex = mixed(s)
        scale = (EDV_ML / cut_ellipsoid_ml(*ED[:3])) ** (1 / 3)
        return [scale * x for x in (a, c, b, wall, apex)]

    # The share of the way between both shapes at which the cavity has its volume.
    wanted = EDV_ML + share * (ESV_ML - EDV_ML)
    low, high = 0.0, 1.0
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if cut_ellipsoid_ml(*at(middle)[:3]) > wanted else (low, middle)
    a, c, b, wall, apex = at(low)
    a0, c0, b0, wall0, apex0 = at(0)
    muscle = cut_ellipsoid_ml(a0 + wall0, c0 + apex0, b0) - cut_ellipsoid_ml(a0, c0, b0)
    low, high = 0.0, 40.0
    for _ in range(60):
        middle = 0.5 * (low + high)
        less = cut_ellipsoid_ml(a + middle, c + apex, b) - cut_ellipsoid_ml(a, c, b) < muscle
        low, high = (middle, high) if less else (low, middle)
    return (a, c, b), (a + low, c + apex, b)


def surface(a, c, b, rows, columns):
    """Closed: from the apex to the base's rim, then flat to the middle; outward. z towards the base."""
    points = [(0.0, 0.0, -c)]
    end = math.acos(max(-1.0, min(1.0, -b / c)))
    for row in range(1, rows + 1):
        angle = end * row / rows
        radius, z = a * math.sin(angle), -c * math.cos(angle)
        points += [(radius * math.cos(2 * math.pi * n / columns),
                    radius * math.sin(2 * math.pi * n / columns), z) for n in range(columns)]
    points.append((0.0, 0.0, -c * math.cos(end)))
    triangles = []
    for n in range(columns):
        m = (n + 1) % columns
        triangles.append((0, 1 + m, 1 + n))
        for row in range(rows - 1):
            low, high = 1 + row * columns, 1 + (row + 1) * columns
            triangles += [(low + n, low + m, high + m), (low + n, high + m, high + n)]
        last = 1 + (rows - 1) * columns
        triangles.append((last + n, last + m, len(points) - 1))
    return points, triangles


def write_ply(file, points, triangles):
    with open(file, "w") as out:
        out.write(f"ply\nformat ascii 1.0\nelement vertex {len(points)}\nproperty float x\n"
                  f"property float y\nproperty float z\nelement face {len(triangles)}\n"
                  "property list uchar int vertex_indices\nend_header\n")
        out.writelines("%.9g %.9g %.9g\n" % p for p in points)
        out.writelines("3 %d %d %d\n" % t for t in triangles)


def write_obj(file, points, triangles):
    with open(file, "w") as out:
        out.writelines("v %.9g %.9g %.9g\n" % p for p in points)
        out.writelines("f %d %d %d\n" % tuple(n + 1 for n in t) for t in triangles)


def write_stl(file, points, triangles):
    with open(file, "wb") as out:
        out.write(b"\0" * 80 + struct.pack("<I", len(triangles)))
        for t in triangles:
            out.write(struct.pack("<12fH", 0, 0, 0, *(x for n in t for x in points[n]), 0))


def main():
    folder = pathlib.Path(sys.argv[1])
    own = "--own-triangles" in sys.argv[2:]
    folder.mkdir(parents=True, exist_ok=True)
    names = {"heart": [], "lv_blood": []}
    truth = {"heart_ml": [], "lv_blood_ml": []}
    for key in range(KEYS):
        cavity, outside = shape(key / (KEYS - 1))
        for structure, axes in (("lv_blood", cavity), ("heart", outside)):
            rows = 60 + (3 * key if own else 0)
            mesh = surface(*axes, rows, 96)
            if own:
                write, end = (write_obj, "obj") if key % 2 else (write_stl, "stl")
            else:
                write, end = write_ply, "ply"
            names[structure].append(f"{structure}_{key}.{end}")
            write(folder / names[structure][-1], *mesh)
            truth[structure + "_ml"].append(cut_ellipsoid_ml(*axes))
    (folder / "truth.json").write_text(json.dumps(truth, indent=2) + "\n")
    (folder / "ventricle.json").write_text(json.dumps(
        {"rr_interval_s": 60 / 110, "phases": 21, "contraction_phases": 8, "voxel_mm": 1,
         "structures": names}, indent=2) + "\n")


if __name__ == "__main__":
    main()
