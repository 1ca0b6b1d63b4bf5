"""Confidence: the chance that an answer is within 0.05 sqrt(area) of the truth."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree
from scipy.special import expit

from sherd.arrays import Bools, Floats
from sherd.correspondence.registration import Deformation
from sherd.correspondence.working_placement import Queries, WorkingPlacement
from sherd.mesh.geometry import lengths, vertex_normals
from sherd.surface.described import DescribedSurface

__all__ = [
    "FEATURES",
    "LEAST",
    "MOST",
    "above",
    "confidence_features",
    "confidences",
    "foreign_vertices",
    "lies_elsewhere",
    "matched_vertices",
    "measured_chance",
    "share_laid_double",
]


FEATURES = ("one", "lack of similarity", "strain", "disagreement", "whole lack", "whole strain")
# Fitted on nine parts of three animated animals (cat, lion, horse; cuts and holes, meshed anew),
# 32,000 vertices: above 0.2 each tenth was kept within 0.15, all together within 0.01.
COEFFICIENTS = (8.2, -6.3, -1.1, -46.0, -7.7, -9.3)
# A confidence is the chance of an error below this.
NEAR = 0.05
# Nothing found by measuring is certain.
LEAST, MOST = 0.005, 0.995
# A vertex is unmatched if neighborhoods disagree this much and the skin tears besides.
UNLIKE, TORN = 0.5, 0.6
# Of the largest component's similarity minus half its strain, balls of 1 to 12 % of the part's area
# that belong nowhere had at most 0.62 (24 parts of four animals), slices of those animals with 1 %
# of the area and more at least 0.70, however strained. Counting strain in full mixes them.
FOREIGN = 0.65
# Points of the part farther apart than two of the largest neighborhoods are wide, which come to lie
# within the size of a label's cell: a right placement has none.
APART, TOGETHER = 0.2, 0.02
# What lay within three such cells on the part, too, lies together by itself: inner and outer layer
# of a bone, or both sides of a gap that a camera left, around which paths along the skin are long.
# Of halves of two mouse skulls on themselves, laid right, 0.33 and 0.27 are double without this,
# 0.01 and 0.04 with it; it changes no verdict on 181 placements of animals, right and foreign. Of a
# scan in a hundred shreds, between which there are no paths, 0.83 to 0.94 were double wherever they
# lay: now six draws that lie 0.021 off and less have 0.03 to 0.09, one 0.05 off has 0.43.
STRAIGHT = 3 * TOGETHER


def above(value: float, middle: float, step: float) -> float:
    """How surely a value is above a limit: a half at the middle, 0.95 three steps above."""
    return float(expit((value - middle) / step))


def measured_chance(log_odds: float) -> float:
    """The logarithm of odds as a chance, kept inside [0.005, 0.995]."""
    return float(np.clip(expit(log_odds), LEAST, MOST))


def confidence_features(
    part: DescribedSurface, queries: Queries, best: WorkingPlacement, other: WorkingPlacement
) -> Floats:
    """Features (n', 6) of every vertex of the part itself, see `FEATURES`; near 0 when all is well.

    Lack of similarity of the neighborhoods and strain of the elastic surface, both averaged over
    the vertex's surroundings; distance between the two placements, at most 0.3; and the
    mean lack and strain over the whole part.
    """
    positions = part.mesh.vertices
    near = cKDTree(positions[queries.vertices]).query(positions, k=min(8, len(queries.vertices)))[1]
    near = near.reshape(len(positions), -1)
    lack = (1.0 - np.clip(best.similarity, 0.0, 1.0))[near].mean(axis=1)
    strain = np.minimum(best.strain[queries.vertices], 1.0)[near].mean(axis=1)
    apart = best.distances_to(other)
    ones = np.ones(len(positions))
    features = np.stack(
        [ones, lack, strain, np.minimum(apart, 0.3), ones * lack.mean(), ones * strain.mean()],
        axis=1,
    )
    return part.working.at_own_vertices(features)


def confidences(features: Floats) -> Floats:
    """`1 / (1 + exp(-features @ coefficients))` of (n, 6) features, kept inside [0.005, 0.995].

    The coefficients are a logistic regression over animated shapes with known truth; no pair of
    SHREC'16 was used.
    """
    result: Floats = np.clip(expit(features @ np.array(COEFFICIENTS)), LEAST, MOST)
    return result


def lies_elsewhere(
    part: DescribedSurface, best: WorkingPlacement, rival: WorkingPlacement
) -> Bools:
    """The vertices (n',) of the part itself that a rival lays farther off than an error counts."""
    apart = best.distances_to(rival)
    return part.working.at_own_vertices(apart) > NEAR


def matched_vertices(features: Floats) -> Bools:
    """False where surroundings are unlike and torn: the full shape has no such point."""
    unlike: Bools = (features[:, 1] > UNLIKE) & (features[:, 2] > TORN)
    return ~unlike


def foreign_vertices(part: DescribedSurface, queries: Queries, best: WorkingPlacement) -> Bools:
    """The vertices (n',) of the part itself whose component fits nowhere: clutter.

    All components are placed together, so one that has no place is laid somewhere all the same,
    unlike its surroundings and strained. A component is judged by its own similarity minus half
    its strain, against the largest one; a component that asked nothing is not judged.
    """
    labels = part.mesh.component_labels
    count = int(labels.max()) + 1
    asked = np.bincount(labels[queries.vertices], minlength=count)
    similarity = np.bincount(labels[queries.vertices], best.similarity, count)
    areas = part.mesh.vertex_areas
    strain = np.bincount(labels, areas * np.minimum(best.strain, 1.0), count)
    total = np.bincount(labels, areas, count)
    score = similarity / np.maximum(asked, 1) - 0.5 * strain / np.maximum(total, 1e-300)
    foreign = (asked > 0) & (score < FOREIGN * score[total.argmax()])
    own = part.working.working_vertices(np.arange(part.placed.vertex_count))
    result: Bools = foreign[labels[own]]
    return result


def share_laid_double(part: DescribedSurface, deformation: Deformation) -> float:
    """Share of the part's nodes that lie where another point of the part lies, from 0 to 1.

    Two legs laid on one leg have similar neighborhoods and no strain; only this tells. The other
    side of a thin sheet looks the other way and does not count, nor does another layer that is as
    near on the part itself.
    """
    positions, own = deformation.positions, part.mesh.vertices
    normals = vertex_normals(positions, part.mesh.faces)
    found = cKDTree(positions).query_ball_point(positions[part.sparse.vertices], TOGETHER)
    nodes, distances = part.sparse.vertices, part.sparse.distances
    double = 0
    for node, row in enumerate(found):
        near = np.asarray(row, dtype=np.int64)
        same_side = normals[near] @ normals[nodes[node]] > 0.5
        apart = lengths(own[near] - own[nodes[node]]) >= STRAIGHT
        double += bool((same_side & apart & (distances[node, near] > APART)).any())
    return double / len(nodes)
