"""Confidence intervals of a share whose trials come in clusters (the matches of one pair are not independent)."""

from typing import NamedTuple

import numpy as np

from ..arrays import frozen_array
from ..errors import BadParameter

ONE_CLUSTER = "Wilson, one pair only"


class Interval(NamedTuple):
    """Bounds in [0, 1] and how they were found."""

    low: float
    high: float
    method: str


def clustered_interval(successes: object, trials: object, confidence: float = 0.95) -> Interval | None:
    """The interval of sum(successes) / sum(trials), one entry a cluster; None without a trial.

    `successes` and `trials` are (G,) whole numbers. The general case is the cluster-robust one. A share of 0 or 1 takes
    Clopper-Pearson with the effective number of trials, one cluster alone (which tells nothing of others) and
    clusters of exactly equal shares (which would give an interval of no width) take Wilson's; `method` says so.
    """
    n = frozen_array(trials, np.int64, (None,), "The trials")
    k = frozen_array(successes, np.int64, n.shape, "The successes")
    if (k < 0).any() or (k > n).any():
        raise BadParameter("A cluster has fewer than 0 or more successes than trials; count again.")
    if not 0 < confidence < 1:
        raise BadParameter(f"A confidence of {confidence:g} is not between 0 and 1; use 0.95.")
    k, n = k[n > 0], n[n > 0]
    if len(n) == 0:
        return None
    if len(n) == 1:
        return wilson(int(k[0]), int(n[0]), confidence)._replace(method=ONE_CLUSTER)
    if k.sum() in (0, n.sum()):
        return clopper_pearson(float(k.sum()), float(n.sum()), len(n), confidence)
    if (k * n.sum() == n * k.sum()).all():
        return wilson(int(k.sum()), int(n.sum()), confidence)._replace(method="Wilson, equal pairs")
    return cluster_robust(k, n, confidence)


def ratio_interval(parts: object, wholes: object, confidence: float = 0.95) -> Interval | None:
    """The interval of sum(parts) / sum(wholes) for amounts such as areas, one entry a cluster.

    None where nothing can be said: fewer than two clusters, a share of 0 or 1, or clusters of exactly equal shares.
    """
    n = frozen_array(wholes, np.float64, (None,), "The wholes")
    k = frozen_array(parts, np.float64, n.shape, "The parts")
    if (k < 0).any() or (k > n * (1 + 1e-9)).any():
        raise BadParameter("A cluster has less than nothing or more than its whole; measure again.")
    k, n = k[n > 0], n[n > 0]
    if len(n) < 2 or not 0 < k.sum() < n.sum() or np.ptp(k / n) < 1e-12:
        return None
    return cluster_robust(k, n, confidence)


def weighted_interval(parts: object, wholes: object, squares: object, confidence: float = 0.95) -> Interval | None:
    """The interval of sum(parts) / sum(wholes) for sums of unequal weights, one entry a cluster; None without a trial.

    `squares` (G,) are the sums of the squared weights of the trials. The general case is that of `ratio_interval`; where
    it says nothing, the trials count as their effective number (Kish 1965), (sum of weights)² / sum of squared weights:
    Clopper-Pearson at a share of 0 or 1, Wilson's with one cluster or clusters of equal shares.
    """
    n = frozen_array(wholes, np.float64, (None,), "The wholes")
    k = frozen_array(parts, np.float64, n.shape, "The parts")
    q = frozen_array(squares, np.float64, n.shape, "The squares")
    clusters = int((n > 0).sum())
    if clusters == 0:
        return None
    found = ratio_interval(k, n, confidence)
    if found is not None:
        return found._replace(method="cluster-robust GLM, t, weighted")
    share, effective = float(k.sum() / n.sum()), float(n.sum() ** 2 / q.sum())
    if clusters > 1 and share in (0.0, 1.0):
        found = clopper_pearson(share * effective, effective, clusters, confidence)
    else:
        found = wilson(share * effective, effective, confidence)
    name = ONE_CLUSTER if clusters == 1 else f"{found.method}, equal pairs" if 0 < share < 1 else found.method
    return found._replace(method=f"{name}, weighted")


def cluster_robust(k: np.ndarray, n: np.ndarray, confidence: float = 0.95) -> Interval:
    """Binomial GLM with only a constant, covariance robust to clusters, t, back-transformed from the logit.

    With one coefficient the sandwich (Liang & Zeger, Biometrika 73, 1986) is a sum over clusters of (k - n p)². Each is
    raised by 1 / (1 - n/N)², which makes it the delete-one jackknife (MacKinnon & White, J. Econometrics 29, 1985):
    se² = (G-1)/G Σ (p without the cluster - p)² / (p (1-p))². t has one degree fewer than the effective number of
    clusters, N² / Σ n² (Carter, Schnepel & Steigerwald, Rev. Econ. Stat. 99, 2017). For clusters of equal size both
    are what G clusters give, G/(G-1) Σ (k - n p)² with G - 1 degrees. `k`, `n` (G,) with G >= 2 and a share strictly
    between 0 and 1.
    """
    from scipy.special import expit, logit, stdtrit

    g, p = len(n), k.sum() / n.sum()
    without = (k.sum() - k) / (n.sum() - n)
    error = np.sqrt((g - 1) / g * np.sum((without - p) ** 2.0)) / (p * (1 - p))
    degrees = max(float(n.sum()) ** 2 / float(np.sum(np.square(n, dtype=np.float64))) - 1, 1.0)
    reach = stdtrit(degrees, (1 + confidence) / 2) * error
    return Interval(float(expit(logit(p) - reach)), float(expit(logit(p) + reach)), "cluster-robust GLM, t")


def clopper_pearson(k: float, n: float, clusters: int, confidence: float = 0.95) -> Interval:
    """Exact binomial interval, its number of trials lowered to n (t_(n-1) / t_(G-1))² for G clusters.

    Korn & Graubard, Survey Methodology 24 (1998); the design effect is taken as 1, which is all that can be said where
    every trial came out alike.
    """
    from scipy.special import betaincinv, stdtrit

    upper = (1 + confidence) / 2
    shrink = (stdtrit(max(n - 1, 1), upper) / stdtrit(clusters - 1, upper)) ** 2 if clusters > 1 else 1.0
    shrink = min(float(shrink), 1.0)
    k, n = k * shrink, n * shrink
    low = float(betaincinv(k, n - k + 1, 1 - upper)) if k > 0 else 0.0
    high = float(betaincinv(k + 1, n - k, upper)) if k < n else 1.0
    return Interval(low, high, "Clopper-Pearson, adjusted n")


def wilson(k: float, n: float, confidence: float = 0.95) -> Interval:
    """Wilson's score interval of k of n independent trials (JASA 22, 1927); n may be an effective number."""
    from scipy.special import ndtri

    z = ndtri((1 + confidence) / 2)
    p = k / n
    centre, reach = p + z * z / (2 * n), z * np.sqrt(p * (1 - p) / n + z * z / (4 * n * n))
    scale = 1 + z * z / n
    low, high = float((centre - reach) / scale), float((centre + reach) / scale)
    return Interval(low if k > 0 else 0.0, high if k < n else 1.0, "Wilson")
