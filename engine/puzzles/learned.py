"""The calibrated probability of a join: small networks fitted to pictures with known truth.

`learned.json` is written by `tests/benchmarks/puzzle_training.py`, which also prints how well the fit does on pictures
that it was not fitted to. See `networks` for their form; a logistic function is at
the end.
"""

from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from ..networks import log_odds, logistic, read_networks
from ..progress import Progress, share
from .candidates import Candidates, border_features, context_features, exclusive, gallagher_ratio, looks_of
from .measures import Strips, dissimilarity_of_pairs

FILE = Path(__file__).with_name("learned.json")
MOST = 6  # candidates of a side that loops are sought among


@lru_cache(maxsize=1)
def weights() -> dict[str, Any]:
    """The fitted numbers, with arrays for lists."""
    return read_networks(FILE)


def network(net: dict[str, Any], inputs: np.ndarray) -> np.ndarray:
    """The output (c,) float64 in (0, 1) of a network for inputs (c, f)."""
    return logistic(log_odds(net, inputs)[:, 0])


def learned_probability(
    candidates: Candidates, rasters: np.ndarray, *, turned: bool, worn: bool, progress: Progress
) -> tuple[np.ndarray, np.ndarray]:
    """The probability of each candidate by its borders alone and after its neighbourhood was heard, both (c,) float64.

    First a network on the border features, then networks that also see the rivals and the 2 × 2 loops through the
    candidate, with the probabilities of the round before. No side's probabilities sum to more than 1.
    """
    nets = weights()["worn" if worn else "clean"]
    borders = border_features(candidates, looks_of(rasters, worn), turned, share(progress, 0.0, 0.7))
    first = probability = exclusive(network(nets["border"], borders), candidates)
    for number, net in enumerate(nets["context"]):
        progress(0.7 + 0.3 * number / len(nets["context"]), "looking for loops")
        inputs = np.concatenate([context_features(probability, candidates, MOST), borders], axis=1)
        probability = exclusive(network(net, inputs), candidates)
    return first, probability


def single_probability(measure: str, candidates: Candidates, strips: Strips) -> tuple[np.ndarray, np.ndarray]:
    """D and the calibrated probability (c,) by one measure alone: logistic in the logarithm of Gallagher's ratio N."""
    values = dissimilarity_of_pairs(measure, strips, candidates.pairs, parts=2)
    constant, slope = weights()["single"][measure]
    ratio = np.log(np.maximum(gallagher_ratio(values, candidates), 1e-9))
    return values, exclusive(1 / (1 + np.exp(-(constant + slope * ratio).clip(-30, 30))), candidates)


def contact_inputs(own: np.ndarray, others: np.ndarray) -> np.ndarray:
    """What the confidence of a placed join is made of, (j, 8): its own log odds (j,), and the mean log odds of the other
    contacts of its two pieces (j, 2), divided by 4, and products of them."""
    o, a, b = own / 4, others.max(axis=1) / 4, others.min(axis=1) / 4
    return np.column_stack([o, a, b, o * a, o * b, a * b, np.maximum(o, 0), np.maximum(b, 0)])


def placed_probability(own: np.ndarray, others: np.ndarray) -> np.ndarray:
    """The calibrated probability (j,) that joins in an assembled picture are right: a doubtful join between two pieces
    whose other contacts are certain is most likely right."""
    constant, *slopes = weights()["placed"]
    return 1 / (1 + np.exp(-(constant + contact_inputs(own, others) @ np.array(slopes)).clip(-30, 30)))
