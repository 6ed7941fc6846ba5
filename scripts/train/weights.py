"""The weights of an exported ONNX file as a network that goes on learning.

Export folds each batch norm into the convolution before it. Here each gets one back whose gain and shift undo
what it does on the slices that it is given: evaluated, the network is the exported one.
"""
import json
import pathlib

import cv2
import numpy
import torch
from torch import nn

from checkpoint import BadCheckpoint
from model import HeartNet


def convolutions(file: pathlib.Path) -> list[tuple[torch.Tensor, torch.Tensor]]:
    """Weights and bias of every convolution, in the order in which they run.  @throws BadCheckpoint"""
    try:
        net = cv2.dnn.readNetFromONNX(str(file))
    except cv2.error:
        raise BadCheckpoint(f"{file} is not there or is no ONNX file that OpenCV reads") from None
    found = []
    for name in net.getLayerNames():
        layer = net.getLayerId(name)
        if net.getLayer(layer).type == "Convolution":
            found.append(tuple(torch.from_numpy(numpy.array(net.getParam(layer, n))) for n in (0, 1)))
    return found


def in_order(model: HeartNet) -> list[tuple[nn.Conv2d, nn.BatchNorm2d | None]]:
    """Each convolution with the batch norm behind it, as `forward` runs them."""
    def of(block: nn.Sequential) -> list[tuple[nn.Conv2d, nn.BatchNorm2d | None]]:
        layers = list(block)
        return [(layer, layers[n + 1]) for n, layer in enumerate(layers) if isinstance(layer, nn.Conv2d)]
    found = [pair for block in model.down for pair in of(block)]
    for level in reversed(range(len(model.up))):
        found += [(model.narrow[level], None), *of(model.up[level])]
    return [*found, (model.head, None)]


def exported(file: pathlib.Path, slices: torch.Tensor) -> HeartNet:
    """The network of an ONNX file of `export.py`, batch norms measured on `slices` (N x 5 x H x W).

    @throws BadCheckpoint where the file is of another network
    """
    model = HeartNet()
    layers, weights = in_order(model), convolutions(file)
    if [tuple(layer.weight.shape) for layer, _ in layers] != [tuple(w.shape) for w, _ in weights]:
        raise BadCheckpoint(f"{file} is of a network with other layers; train anew")
    hooks = []

    def undone(norm: nn.BatchNorm2d, bias: torch.Tensor):
        """Run just before the norm: its statistics are those of its input, its output is input + bias."""
        def measure(_, inputs) -> None:
            values = inputs[0]
            norm.running_mean.copy_(values.mean((0, 2, 3)))
            norm.running_var.copy_(values.var((0, 2, 3)))
            norm.weight.copy_((norm.running_var + norm.eps).sqrt())
            norm.bias.copy_(norm.running_mean + bias)
        return measure
    with torch.no_grad():
        for (layer, norm), (weight, bias) in zip(layers, weights):
            layer.weight.copy_(weight)
            if norm is None:
                layer.bias.copy_(bias.flatten())
            else:
                hooks.append(norm.register_forward_pre_hook(undone(norm, bias.flatten())))
        model.eval()(slices)
    for hook in hooks:
        hook.remove()
    return model


def trained_before(file: pathlib.Path) -> tuple[int, float]:
    """Samples and minutes that the network of an ONNX file has learned, as its description says.

    @throws BadCheckpoint where it has none
    """
    try:
        card = json.loads(file.with_suffix(".json").read_text())["card"]
        return int(card["samples"]), float(card["minutes"])
    except (OSError, ValueError, KeyError, TypeError):
        raise BadCheckpoint(f"{file.with_suffix('.json')} does not tell how long {file.name} was trained; give "
                            "the two files that export.py wrote") from None
