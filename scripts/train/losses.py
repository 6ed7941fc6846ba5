"""What is trained for, and what it is judged by."""
import torch
import torch.nn.functional as F

from draws import UNKNOWN
from model import OUTPUTS

# Of the cross entropy. Thin structures have few pixels; moderate, because what is exported are
# probabilities, which a weight moves by its logarithm.
CLASS_WEIGHTS = (1.0, 1.5, 1.5, 1.5, 2.0, 1.5, 1.5, 1.5)
DICE_SHARE = 0.7
DICE_PIXELS = 20.0  # added above and below: a structure of which a batch has nothing is not divided by 0


def loss(logits: torch.Tensor, labels: torch.Tensor) -> torch.Tensor:
    """Cross entropy + 0.7 soft Dice over the foreground of the whole batch; pixels of 255 do not count.

    @param logits N x 8 x H x W  @param labels N x H x W int64
    """
    logs = F.log_softmax(logits.float(), 1)
    weights = logs.new_tensor(CLASS_WEIGHTS)
    known = labels != UNKNOWN
    labels = labels.where(known, labels.new_tensor(-100))
    if not known.any():
        return logs.sum() * 0
    entropy = F.nll_loss(logs, labels, weights, ignore_index=-100)
    found = logs.exp() * known.unsqueeze(1)
    truth = torch.zeros_like(found).scatter_(1, labels.clamp(min=0).unsqueeze(1), 1.0)
    truth *= known.unsqueeze(1)
    both = (found * truth).sum((0, 2, 3))[1:]
    sizes = (found.sum((0, 2, 3)) + truth.sum((0, 2, 3)))[1:]
    dice = (2 * both + DICE_PIXELS) / (sizes + DICE_PIXELS)
    return entropy + DICE_SHARE * (1 - dice.mean())


class DiceCount:
    """Dice of the most likely structure against the label, over all slices that were added."""

    def __init__(self) -> None:
        self.both = torch.zeros(len(OUTPUTS))
        self.sizes = torch.zeros(len(OUTPUTS))

    def add(self, logits: torch.Tensor, labels: torch.Tensor) -> None:
        known = labels != UNKNOWN
        truth = labels[known]
        found = logits.argmax(1)[known]
        count = len(OUTPUTS)
        self.both += torch.bincount(truth[truth == found], minlength=count)
        self.sizes += torch.bincount(truth, minlength=count) + torch.bincount(found, minlength=count)

    def dice(self) -> dict[str, float]:
        """By name; a structure that is neither drawn nor found has none."""
        return {name: round(float(2 * both / size), 4)
                for name, both, size in zip(OUTPUTS, self.both, self.sizes) if size > 0}
