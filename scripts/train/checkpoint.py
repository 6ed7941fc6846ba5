"""A run on disk: written whole or not at all, read without running what it holds."""
import json
import os
import pathlib
import pickle
import tempfile

import torch

from model import CHANNELS, OUTPUTS, HeartNet

FORMAT = 1


class BadCheckpoint(ValueError):
    """A file that is none, or of another network; one sentence says which and what to do."""


def save(file: pathlib.Path, tensors: dict, plain: dict) -> None:
    """Replaces `file` when all of it is on disk, so that a kill or a full disk leaves the old one.

    @param tensors what holds tensors, at any depth  @param plain the rest; kept as JSON, because torch
                   1.13 reads no float unless it may run what a file holds
    """
    plain = dict(plain, format=FORMAT, channels=list(CHANNELS), outputs=list(OUTPUTS))
    part = tempfile.NamedTemporaryFile(dir=file.parent, prefix=".partial-", delete=False)
    try:
        with part:
            torch.save(dict(tensors, plain=json.dumps(plain)), part)
            part.flush()
            os.fsync(part.fileno())
        os.replace(part.name, file)
    except BaseException:
        pathlib.Path(part.name).unlink(missing_ok=True)
        raise


def load(file: pathlib.Path) -> dict:
    """What was saved, tensors and the rest in one dictionary.  @throws BadCheckpoint"""
    try:
        content = torch.load(file, map_location="cpu", weights_only=True)
        content.update(json.loads(content.pop("plain")))
    except FileNotFoundError:
        raise BadCheckpoint(f"{file} is not there; give the checkpoint.pt of a run") from None
    except (OSError, RuntimeError, EOFError, ValueError, KeyError, AttributeError, TypeError,
            pickle.UnpicklingError) as error:
        raise BadCheckpoint(f"{file} is no checkpoint of train.py, or is cut; "
                            "give the checkpoint.pt of a run") from error
    if content.get("format") != FORMAT:
        raise BadCheckpoint(f"{file} was written by another version of train.py; train anew")
    if content["channels"] != list(CHANNELS) or content["outputs"] != list(OUTPUTS):
        raise BadCheckpoint(f"{file} is of a network with other channels or outputs; train anew")
    return content


def network(content: dict, which: str) -> HeartNet:
    """The network of a checkpoint.

    @param which "weights" as they were trained, or "average" of them, which is what is used
    """
    model = HeartNet(tuple(content["widths"]))
    model.load_state_dict(content[which])
    return model
