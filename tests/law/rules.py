"""The law of the house: which room may reach which, and where each library may be used.

To let a room use another, add it here and to the room's README, in the same change.
"""

import re
from dataclasses import dataclass

# Room -> the rooms it may include from. Nothing is inherited: what is not named is not allowed.
_BASE = ("runtime/base",)
_ATLAS = ("runtime/base", "runtime/atlas")
_CORE = ("runtime/base", "runtime/atlas", "pipeline/core")
ROOMS = {
    "runtime/base": (),
    "runtime/atlas": _BASE,
    "runtime/field": _ATLAS,
    "runtime/device": _BASE,
    "runtime/haptics": ("runtime/base", "runtime/field"),
    "runtime/c": _ATLAS + ("runtime/field", "runtime/haptics"),
    "runtime/palpation": _ATLAS + ("runtime/field", "runtime/haptics"),
    "runtime/exercise": _ATLAS + ("runtime/palpation",),
    "runtime/plot": _BASE,
    "runtime/viewer": _ATLAS + ("runtime/field", "runtime/device", "runtime/haptics",
                                "runtime/palpation", "runtime/exercise", "runtime/plot",
                                "runtime/app"),
    "runtime/app": _ATLAS + ("runtime/field", "runtime/device", "runtime/haptics",
                             "runtime/palpation", "runtime/exercise", "runtime/plot"),
    "pipeline/core": _ATLAS,
    "pipeline/formats": _CORE,
    "pipeline/ingest": _CORE + ("pipeline/formats",),
    "pipeline/phantom": _CORE,
    "pipeline/motion": _CORE,
    "pipeline/shape": _CORE,
    "pipeline/tissue": _CORE,
    "pipeline/edges": _CORE + ("pipeline/tissue",),
    "pipeline/alarm": _CORE + ("pipeline/motion", "pipeline/tissue"),
    "pipeline/prior": _CORE,
    "pipeline/segment": _CORE + ("pipeline/motion", "pipeline/shape", "pipeline/tissue", "pipeline/edges",
                                 "pipeline/alarm", "pipeline/prior"),
    "pipeline/field": _CORE,
    "pipeline/keyframes": _CORE + ("pipeline/field",),
    "pipeline/mesh": _CORE + ("pipeline/field", "runtime/palpation"),
    "pipeline/pack": _CORE,
    "pipeline/assess": _CORE + ("pipeline/phantom", "pipeline/shape", "runtime/field", "runtime/haptics"),
    "pipeline/report": _CORE + ("runtime/plot",),
    "pipeline/identify": _CORE + ("runtime/palpation",),
    "pipeline/study": _CORE + ("pipeline/formats", "pipeline/field"),
    # The order of the stages, with a study and without.
    "pipeline/build": _CORE + ("pipeline/study", "pipeline/ingest", "pipeline/motion", "pipeline/shape",
                               "pipeline/tissue", "pipeline/alarm", "pipeline/prior", "pipeline/segment",
                               "pipeline/field", "pipeline/mesh", "pipeline/pack", "pipeline/assess",
                               "pipeline/report"),
    # Joins all; and what `validate` measures is what a user of the package feels.
    "pipeline/cli": _CORE + ("runtime/field", "runtime/haptics", "runtime/palpation",
                             "runtime/plot", "runtime/device", "pipeline/build",
                             "pipeline/study", "pipeline/formats", "pipeline/ingest",
                             "pipeline/phantom", "pipeline/tissue", "pipeline/segment",
                             "pipeline/field", "pipeline/mesh", "pipeline/pack",
                             "pipeline/assess", "pipeline/report", "pipeline/identify",
                             "pipeline/keyframes"),
}


@dataclass(frozen=True)
class Library:
    """How a library shows, and the only rooms that may use it."""

    include: re.Pattern  # as written between <> or ""
    header: re.Pattern  # as a path in the compiler's dependency log
    loaded: re.Pattern  # the file name of its shared library
    types: re.Pattern  # a name of its own in a public header
    rooms: tuple


def _library(include, header, loaded, types, *rooms):
    return Library(re.compile(include), re.compile(header), re.compile(loaded),
                   re.compile(types), rooms)


_NEVER = r"(?!)"
LIBRARIES = {
    "VTK": _library(r"^vtk|^Dicom/vtk", r"/include/vtk|/vtk[A-Z]\w*\.(h|txx)$",
                    r"^libvtk", r"\bvtk[A-Z]\w*",
                    "pipeline/ingest", "pipeline/formats", "pipeline/report", "runtime/viewer"),
    "Qt": _library(r"^Q[A-Z]|^Qt[A-Z]", r"/qt5/", r"^libQt5",
                   r"\bQ(Widget|MainWindow|Application|Painter|Image|Color|String|Rect)\b",
                   "runtime/viewer"),
    "OpenCV": _library(r"^opencv(?!2/dnn)", r"/include/opencv(?!.*/opencv2/dnn)", r"^libopencv",
                       r"\bcv::\w+", "pipeline/motion", "pipeline/shape", "pipeline/tissue", "pipeline/edges",
                       "pipeline/segment", "pipeline/report", "pipeline/prior"),
    # The part of OpenCV that runs networks.
    "OpenCV dnn": _library(r"^opencv2/dnn", r"/opencv2/dnn", r"^libopencv_dnn", r"\bcv::dnn\b",
                           "pipeline/prior"),
    "OpenVDB": _library(r"^(open|nano)vdb/", r"/include/(open|nano)vdb/", r"^libopenvdb",
                        r"\b(openvdb|nanovdb)::\w+|\bnamespace (openvdb|nanovdb)\b",
                        "pipeline/field"),
    "CGAL": _library(r"^CGAL/", r"/include/CGAL/", r"^libCGAL|^libgmp|^libmpfr",
                     r"\bCGAL::\w+|\bnamespace CGAL\b", "pipeline/mesh"),
    "OpenMesh": _library(r"^OpenMesh/", r"/include/OpenMesh/", r"^libOpenMesh",
                         r"\bOpenMesh::\w+|\bnamespace OpenMesh\b", "pipeline/mesh"),
    "Draco": _library(r"^draco/", r"/include/draco/", r"^libdraco",
                      r"\bdraco::\w+|\bnamespace draco\b", "runtime/atlas", "pipeline/pack"),
    "GDCM": _library(r"^gdcm", r"/include/gdcm|/gdcm[A-Z]\w*\.h$", r"^libgdcm", r"\bgdcm::\w+",
                     "pipeline/ingest"),
    "niftilib": _library(r"^(nifti/)?(nifti\w*_io|znzlib)\.h$", r"/(nifti\w*_io|znzlib)\.h$",
                         r"^lib(nifti|znz)", r"\bnifti_image\b|\bznzFile\b", "pipeline/formats"),
}

# What no program of the runtime core may see or load: its size, its licence (CGAL is GPL) and
# its start-up time depend on it. Drawing (runtime/viewer) is an optional target beside the core.
HEAVY = ("VTK", "Qt", "OpenCV", "OpenVDB", "CGAL", "OpenMesh")
OUTSIDE_THE_CORE = ("runtime/viewer",)

# Rooms that speak to a person; the others say what they have to in what they return.
SPEAKS = ("pipeline/cli", "runtime/app", "runtime/viewer")

MAX_LINES = 600
SOURCE_FOLDERS = ("pipeline", "runtime", "tests", "scripts")

# What a room may have at the most (see counts.py): of rooms that are not named, "". A module is a .h with its .cpp, a
# knot a circle of includes among them. Rooms that have more than the others are to become smaller, none larger.
MOST = {
    "modules": {"": 40, "pipeline/cli": 46, "pipeline/phantom": 41, "pipeline/segment": 23},
    "constants": {"": 125, "pipeline/edges": 168, "pipeline/segment": 66},
    "knot": {"": 3, "pipeline/formats": 4, "pipeline/ingest": 4},
    "longest function": {"": 80},
}
