"""The network that tells where the heart is: a small U-Net of 2-D slices, and what it may be exported as.

Input: float32 of shape N x 5 x H x W, H and W multiples of 16, pixels of 2 mm; the channels are named
in CHANNELS, their values lie in 0..1.2. Output: N x 8 x H x W logits, one plane a name of OUTPUTS.
Everything is built of what OpenCV 4.6 reads from ONNX: convolutions, ReLU, nearest upsampling, sums.
"""
import copy

import torch
from torch import nn

CHANNELS = ("frame", "below", "above", "mean", "deviation")
OUTPUTS = ("background", "rv_blood", "lv_myocardium", "lv_blood", "rest_of_heart", "la_blood", "ra_blood",
           "aorta")
PIXEL_MM = 2.0      # of every plane
NEIGHBOUR_MM = 8.0  # from `frame` to `below` and to `above`
MULTIPLE = 16       # of height and width: four halvings
ORIENTATIONS = 8    # that are averaged over in use; training shows slices turned and mirrored in any way
TONES = [0.5, 0.75, 1.0]  # of brightness, in which an exam may be shown in use; training draws any contrast
MAX_PARAMETERS = 750_000
# At full size, 1/2, 1/4, 1/8 and 1/16. The two coarsest cost little time, so they have what the budget
# leaves.
WIDTHS = (8, 24, 48, 104, 136)


class Block(nn.Sequential):
    """Convolutions of 3 x 3, each with batch norm and ReLU; the first may halve the size."""

    def __init__(self, inputs: int, outputs: int, convolutions: int = 2, stride: int = 1) -> None:
        layers: list[nn.Module] = []
        for n in range(convolutions):
            layers += [nn.Conv2d(inputs if n == 0 else outputs, outputs, 3, stride if n == 0 else 1, 1,
                                 bias=False),
                       nn.BatchNorm2d(outputs), nn.ReLU(inplace=True)]
        super().__init__(*layers)


class HeartNet(nn.Module):
    """Five levels; a level of the way up adds what the same level of the way down had found."""

    def __init__(self, widths: tuple[int, ...] = WIDTHS) -> None:
        super().__init__()
        self.widths = tuple(widths)
        self.down = nn.ModuleList([Block(len(CHANNELS), widths[0])])
        for wide, wider in zip(widths, widths[1:]):
            self.down.append(Block(wide, wider))
        self.pool = nn.MaxPool2d(2)
        # From a coarse level to the next finer: 1 x 1 to its width, enlarged, added, one block.
        self.narrow = nn.ModuleList(nn.Conv2d(wider, wide, 1) for wide, wider in zip(widths, widths[1:]))
        self.up = nn.ModuleList(Block(wide, wide) for wide in widths[:-1])
        self.enlarge = nn.Upsample(scale_factor=2, mode="nearest")
        self.head = nn.Conv2d(widths[0], len(OUTPUTS), 1)
        # Most pixels are background: that need not be learned first.
        with torch.no_grad():
            self.head.bias.fill_(-4.0)
            self.head.bias[0] = 0.0

    def forward(self, x: torch.Tensor) -> torch.Tensor:
        found = []
        for level, block in enumerate(self.down):
            x = block(self.pool(x) if level else x)
            found.append(x)
        for level in reversed(range(len(self.up))):
            x = self.enlarge(self.narrow[level](x)) + found[level]
            x = self.up[level](x)
        return self.head(x)


def parameters(model: nn.Module) -> int:
    """How many numbers are trained."""
    return sum(p.numel() for p in model.parameters())


def folded(model: HeartNet) -> HeartNet:
    """A copy for use alone, whose batch norms are part of the convolutions before them."""
    model = copy.deepcopy(model).float().eval()
    for block in [*model.down, *model.up]:
        layers = list(block)
        for n, layer in enumerate(layers):
            if isinstance(layer, nn.BatchNorm2d):
                layers[n - 1] = torch.nn.utils.fuse_conv_bn_eval(layers[n - 1], layer)
        kept = [layer for layer in layers if not isinstance(layer, nn.BatchNorm2d)]
        nn.Sequential.__init__(block, *kept)
    return model
