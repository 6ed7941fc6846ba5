#!/usr/bin/env python3
"""Writes the averaged network of a checkpoint as ONNX, with its description beside it.

export.py CHECKPOINT -o NAME.onnx: NAME.onnx and NAME.json, when OpenCV's dnn reads the file and gives
what torch gives. Height and width are left open (multiples of 16). Exit 0 done, 2 usage, 3 bad input.
"""
import argparse
import hashlib
import json
import os
import pathlib
import sys
import tempfile
import time

import cv2
import numpy
import torch

import checkpoint
from model import CHANNELS, MULTIPLE, NEIGHBOUR_MM, ORIENTATIONS, OUTPUTS, PIXEL_MM, TONES, HeartNet, folded

FORMAT = 1
FAMILY = json.loads((pathlib.Path(__file__).resolve().parents[2] / "pipeline/phantom/family.json").read_text())
MAX_BYTES = 3_000_000
OPSET = 11  # the latest whose Resize OpenCV 4.6 reads as this exporter writes it
SIZES = ((192, 192), (160, 224), (128, 144))  # checked one after the other with one net
LARGEST_GAP = 1e-4


class Refused(ValueError):
    """One sentence: why the file is not written."""


def onnx_bytes(model: HeartNet) -> bytes:
    """ONNX of a folded network; batch, height and width are open."""
    with tempfile.TemporaryDirectory() as folder:
        file = pathlib.Path(folder) / "net.onnx"
        torch.onnx.export(model, torch.rand(1, len(CHANNELS), *SIZES[0]), str(file), opset_version=OPSET,
                          input_names=["slices"], output_names=["logits"],
                          dynamic_axes={name: {0: "batch", 2: "height", 3: "width"}
                                        for name in ("slices", "logits")})
        return file.read_bytes()


def largest_gap(model: HeartNet, content: bytes) -> float:
    """Between torch and OpenCV on random slices, over all SIZES and two slices at once.

    @throws Refused where OpenCV does not read the file or gives another shape
    """
    random = numpy.random.default_rng(1)
    try:
        net = cv2.dnn.readNetFromONNX(numpy.frombuffer(content, numpy.uint8))
        gap = 0.0
        for count, (height, width) in [(1, size) for size in SIZES] + [(2, SIZES[0])]:
            slices = random.uniform(0, 1.2, (count, len(CHANNELS), height, width)).astype(numpy.float32)
            net.setInput(slices)
            found = net.forward()
            with torch.no_grad():
                wanted = model(torch.from_numpy(slices)).numpy()
            if found.shape != wanted.shape:
                raise Refused(f"OpenCV {cv2.__version__} gives {found.shape} for {wanted.shape}")
            gap = max(gap, float(abs(found - wanted).max() / max(1.0, float(abs(wanted).max()))))
    except cv2.error as error:
        raise Refused(f"OpenCV {cv2.__version__} does not read what torch {torch.__version__} exports: "
                      f"{str(error).strip().splitlines()[0]}") from error
    return gap


def description(content: bytes, run: dict) -> dict:
    """What a program that uses the file must know, and where the weights come from."""
    return {
        "format": FORMAT, "pixel_mm": PIXEL_MM, "channels": list(CHANNELS), "outputs": list(OUTPUTS),
        "neighbour_mm": NEIGHBOUR_MM, "multiple": MULTIPLE,
        "orientations": ORIENTATIONS, "lv_ml": [FAMILY["lv_edv"]["low"], FAMILY["lv_edv"]["high"]],
        "tones": TONES,
        "sha256": hashlib.sha256(content).hexdigest(),
        "card": {
            "trained_on": "drawn slices of random hearts alone (heart_draws); no image of a person",
            "samples": run["samples"], "minutes": round(run["minutes"], 1),
            **{f"held_out_dice_{name}": value for name, value in (run["dice"] or {}).items()},
            "date": run["date"], "licence": "CC0-1.0",
        },
    }


def put(file: pathlib.Path, content: bytes) -> None:
    """Whole or not at all."""
    with tempfile.NamedTemporaryFile(dir=file.parent, prefix=".partial-", delete=False) as part:
        part.write(content)
    os.chmod(part.name, 0o644)
    os.replace(part.name, file)


def main() -> int:
    parser = argparse.ArgumentParser(description="Exports the averaged network of a checkpoint as ONNX.")
    parser.add_argument("checkpoint", type=pathlib.Path)
    parser.add_argument("-o", dest="out", type=pathlib.Path, required=True, metavar="NAME.onnx")
    args = parser.parse_args()
    if args.out.suffix != ".onnx":
        parser.error("-o wants a name that ends in .onnx")
    torch.set_num_threads(1)
    try:
        run = checkpoint.load(args.checkpoint)
        trained = checkpoint.network(run, "average").eval()
        model = folded(trained)
        slices = torch.rand(1, len(CHANNELS), *SIZES[0])
        with torch.no_grad():
            before, after = trained(slices), model(slices)
        if not torch.isfinite(after).all() or \
                float((before - after).abs().max()) > LARGEST_GAP * max(1.0, float(before.abs().max())):
            raise Refused("with batch norm folded the network gives something else; its training failed")
        content = onnx_bytes(model)
        if len(content) > MAX_BYTES:
            raise Refused(f"{len(content)} bytes are more than {MAX_BYTES}; make WIDTHS in model.py less")
        gap = largest_gap(model, content)
        if gap > LARGEST_GAP:
            raise Refused(f"OpenCV's output differs by {gap:.1e} of the largest value")
        told = description(content, run)
        put(args.out, content)
        put(args.out.with_suffix(".json"), (json.dumps(told, indent=2) + "\n").encode())
    except (checkpoint.BadCheckpoint, Refused, OSError) as error:
        print(f"export: {error}; nothing is written" if isinstance(error, Refused) else f"export: {error}",
              file=sys.stderr)
        return 3
    print(f"{args.out}: {len(content)} bytes, sha256 {told['sha256']}, within {gap:.1e} of torch")
    return 0


if __name__ == "__main__":
    sys.exit(main())
