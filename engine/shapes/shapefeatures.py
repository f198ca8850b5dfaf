"""Shape features by principal components, and volume and area, of unions of segments."""

import numpy as np

from .mesh import Mesh, face_areas
from .segmentation import SegmentedShape

_LEAST_VOLUME = 1e-4  # share of the whole's: sheets have none


def surface_covariances(mesh: Mesh, labels: np.ndarray, members: np.ndarray) -> np.ndarray:
    """Covariance of the surface of each union `members` (k, s) of the segments, (k, 3, 3).

    Exact: the second moments of a triangle are those of its three edge midpoints.
    """
    count = members.shape[1]
    corners = mesh.vertices[mesh.faces]
    corners = corners - corners.reshape(-1, 3).mean(axis=0)
    middles = (corners + np.roll(corners, -1, axis=1)) / 2
    area = face_areas(mesh) + 1e-300
    mass = np.bincount(labels, area, minlength=count)
    first = np.zeros((count, 3))
    second = np.zeros((count, 3, 3))
    np.add.at(first, labels, area[:, None] * middles.mean(axis=1))
    np.add.at(second, labels, area[:, None, None] * np.einsum("nkd,nke->nde", middles, middles) / 3)
    m = members.astype(np.float64)
    total = np.maximum(m @ mass, 1e-300)
    mean = m @ first / total[:, None]
    return (m @ second.reshape(count, 9) / total[:, None]).reshape(-1, 3, 3) - mean[:, :, None] * mean[:, None]


def principal_features(covariance: np.ndarray) -> np.ndarray:
    """Linearity, planarity, sphericity, omnivariance, entropy and change of curvature, (k, 6) float32 in [0, 1].

    With the eigenvalues l1 >= l2 >= l3 of the covariances (k, 3, 3), scaled to sum 1: (l1 - l2)/l1, (l2 - l3)/l1,
    l3/l1, 3 ∛(l1 l2 l3), -Σ l ln l / ln 3, and 3 l3.
    """
    values = np.maximum(np.linalg.eigvalsh(covariance)[:, ::-1], 0.0)
    l1, l2, l3 = (values / np.maximum(values.sum(axis=1, keepdims=True), 1e-300)).T
    entropy = -sum(x * np.log(np.maximum(x, 1e-300)) for x in (l1, l2, l3)) / np.log(3)
    most = np.maximum(l1, 1e-300)
    features = ((l1 - l2) / most, (l2 - l3) / most, l3 / most, 3 * np.cbrt(l1 * l2 * l3), entropy, 3 * l3)
    return np.stack(features, axis=1).astype(np.float32)


def principal_shape(shape: SegmentedShape, members: np.ndarray) -> np.ndarray:
    """The six features of each union of a shape's segments, (k, 6) float32; see `principal_features`."""
    return principal_features(surface_covariances(shape.mesh, shape.segmentation.labels, members))


def volume_and_area(members: np.ndarray, area: np.ndarray, volume: np.ndarray) -> np.ndarray:
    """Log share of the whole shape's area, and of its volume, of each union, (k, 2) float32.

    `area` and `volume` (s,) of the segments; of a shape without volume the second is a copy of the first.
    """
    m = members.astype(np.float64)
    surface = np.log(np.maximum(m @ area / max(area.sum(), 1e-300), 1e-9))
    if not volume.sum() > 1e-9 * area.sum() ** 1.5:
        return np.stack([surface, surface], axis=1).astype(np.float32)
    return np.stack([surface, np.log(np.maximum(m @ volume / volume.sum(), _LEAST_VOLUME))], axis=1).astype(np.float32)
