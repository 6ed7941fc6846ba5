#!/usr/bin/env python3
"""Makes the models that the tests of pipeline/prior run: make_models.py [FOLDER]

Written to models/ beside this script unless another folder is named. Needs python3-torch.
"""
import argparse
import hashlib
import json
import pathlib

import torch
from torch import nn

CHANNELS = ["frame", "below", "above", "mean", "deviation"]
OUTPUTS = ["background", "rv_blood", "lv_myocardium", "lv_blood", "rest_of_heart", "la_blood", "ra_blood",
           "aorta"]


def weight(output, channel):
    """As in made_models.cpp, where the tests compute the same in closed form."""
    return ((7 * output + 3 * channel * channel + 5 * output * channel + 5) % 11 - 5) * 0.5


def bias(output):
    return ((5 * output + 2) % 7 - 3) * 0.25


def pixelwise(channels, outputs):
    layer = nn.Conv2d(channels, outputs, 1)
    with torch.no_grad():
        for o in range(outputs):
            layer.bias[o] = bias(o)
            for c in range(channels):
                layer.weight[o, c, 0, 0] = weight(o, c)
    return layer


class UNet(nn.Module):
    """Levels of two convolutions, added on the way up, as scripts/train makes them."""

    def __init__(self, channels, outputs, widths):
        super().__init__()
        def block(inputs, width):
            return nn.Sequential(nn.Conv2d(inputs, width, 3, padding=1), nn.ReLU(),
                                 nn.Conv2d(width, width, 3, padding=1), nn.ReLU())
        self.down = nn.ModuleList([block(channels, widths[0])]
                                  + [block(a, b) for a, b in zip(widths, widths[1:])])
        self.narrow = nn.ModuleList(nn.Conv2d(b, a, 1) for a, b in zip(widths, widths[1:]))
        self.up = nn.ModuleList(block(a, a) for a in widths[:-1])
        self.pool = nn.MaxPool2d(2)
        self.enlarge = nn.Upsample(scale_factor=2, mode="nearest")
        self.head = nn.Conv2d(widths[0], outputs, 1)
        for tensor in self.parameters():  # equal tensors become Identity nodes, which OpenCV refuses
            nn.init.normal_(tensor, std=(2 / max(1, tensor[0].numel())) ** 0.5 if tensor.dim() > 1 else 0.1)

    def forward(self, x):
        found = []
        for level, block in enumerate(self.down):
            x = block(self.pool(x) if level else x)
            found.append(x)
        for level in reversed(range(len(self.up))):
            x = self.up[level](self.enlarge(self.narrow[level](x)) + found[level])
        return self.head(x)


def write(file, network, channels, outputs, multiple, side=64):
    torch.onnx.export(network.eval(), torch.zeros(1, len(channels), side, side), str(file), opset_version=11,
                      input_names=["image"], output_names=["logits"],
                      dynamic_axes={name: {0: "n", 2: "h", 3: "w"} for name in ("image", "logits")})
    told = {"format": 1, "pixel_mm": 2.0, "channels": channels, "outputs": outputs, "neighbour_mm": 8.0,
            "multiple": multiple, "sha256": hashlib.sha256(file.read_bytes()).hexdigest(),
            "card": {"made_by": "tests/unit/prior/make_models.py"}}
    file.with_suffix(".json").write_text(json.dumps(told, indent=2) + "\n")
    print(file, file.stat().st_size)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", nargs="?", default=pathlib.Path(__file__).parent / "models",
                        type=pathlib.Path)
    words = parser.parse_args()
    torch.manual_seed(7)
    words.folder.mkdir(parents=True, exist_ok=True)
    mixed = ["mean", "frame", "above", "deviation", "below"]
    write(words.folder / "pixelwise.onnx", pixelwise(5, 8), mixed, OUTPUTS, 4)
    few = ["background", "lv_blood", "rv_blood", "lv_myocardium"]
    write(words.folder / "frame_alone.onnx", pixelwise(1, 4), ["frame"], few, 1)
    write(words.folder / "unet.onnx", UNet(5, 8, (4, 6)), CHANNELS, OUTPUTS, 8)


main()
