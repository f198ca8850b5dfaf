"""The average over sets as the thesis's Tables 3.1 and 3.2 have it."""

from collections.abc import Sequence

from ..errors import BadParameter


def thesis_average(percentages: Sequence[float], pairs: Sequence[int]) -> tuple[float, float]:
    """Mean and deviation over sets as in the thesis's Tables 3.1 and 3.2.

    The mean weighs each set by its pairs, the deviation is the unweighted sample one (n - 1) of the sets: it measures
    the spread between categories. Both in per cent; the deviation of a single set is nan.
    """
    if len(percentages) != len(pairs) or not percentages or min(pairs) < 1:
        raise BadParameter(
            "The thesis's average needs one percentage and one number of pairs, at least 1, for each set."
        )
    mean = sum(value * weight for value, weight in zip(percentages, pairs, strict=True)) / sum(pairs)
    plain = sum(percentages) / len(percentages)
    spread = sum((value - plain) ** 2 for value in percentages)
    return mean, (spread / (len(percentages) - 1)) ** 0.5 if len(percentages) > 1 else float("nan")
