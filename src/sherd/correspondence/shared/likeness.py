"""How alike what two shapes share is where it was laid, among all places where it could lie.

A labeling looks for places that are alike, and it sees both shapes with their own cuts. Once the
answer is known both can be shown only what they share: then both neighborhoods have the same cut,
and a right place is hardly less alike than the best of all places, while a front leg that was laid
on a hind leg is not like it, however well lengths agree. No energy was made small over this, so it
is evidence of its own. And a limb of the other side, or a flank on what merely has its lengths,
is no more alike than its mirror image is at the same place. The mirror image of a whole animal fits
as well as the animal, elsewhere, as it has two equal sides; at the right place it does not.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from sherd.arrays import Bools, Floats, Ints, Singles
from sherd.correspondence.placements import node_similarity
from sherd.correspondence.question import Question
from sherd.descriptors.relief_patches import (
    ReliefPatches,
    patch_similarity,
    patch_similarity_in_pairs,
)
from sherd.descriptors.rotation_shot import trusted_equally
from sherd.surface.described import RADII, DescribedSurface
from sherd.surface.transformed import mirrored

__all__ = [
    "Likeness",
    "handed_by_relief",
    "likeness_inside",
    "mean_likeness",
    "recognized_by_relief",
]

# A place is known to within the middle radius of the neighborhoods that are compared; what is
# nearer than that is the same place.
SAME_PLACE = 0.05
# A place leads if no more than one label in so many is more alike: 30 of 1,200, among which the
# right one is for nine nodes in ten of cuts of one animal (`CANDIDATES` of the labeling).
LEADING = 40
# A place is recognized by its relief if fewer labels of the 1,200 than this are more alike: of what
# is shared rightly in other poses a half to nine tenths are, of what slid to where it is alike on
# another species a third, seldom two. On a small piece labels lie closer, so more of them are at
# what is nearly the same place; as many fewer hold a patch there, half of them on a limb.
MORE_ALIKE = 6
# Two or three nodes say nothing, and a share is known to a twentieth from a hundred.
LEAST_NODES, MOST_NODES = 4, 100


@dataclass(frozen=True)
class Likeness:
    """Of the nodes of one shape that lie in what is shared, each weighing its area.

    Attributes
    ----------
    lack
        Mean of how much less alike its place is than the best place of all; similarities are at
        most 1.
    leading
        Share of those whose places lead.
    handed
        Share of those whose places are more alike to them than to their mirror images: a half where
        nothing says which, or where neighborhoods are their own mirror images.
    """

    lack: float
    leading: float
    handed: float


def likeness_inside(question: Question, there: Floats, own: Bools, other: Bools) -> Likeness | None:
    """How alike the part is to where it was laid, both seeing only what is shared.

    Parameters
    ----------
    question
        The part and the shape it was laid on.
    there
        (n, 3) place on the full shape of each vertex of the part's working mesh.
    own, other
        Vertices (n,) of the part and (m,) of the full shape that are shared.

    Returns
    -------
    Likeness or None
        None where so little is shared that nothing can be said.
    """
    full, part = question.full, question.part
    chosen = _chosen(part, own)
    if len(chosen) < LEAST_NODES or not other.any():
        return None
    nodes = part.sparse.vertices[chosen]
    seen = full.spectra_within(other)

    def alike(shape: DescribedSurface) -> Floats:
        spectra = trusted_equally(shape.spectra_at_within(nodes, own), RADII)
        result: Floats = node_similarity(question, spectra, inside=seen).max(axis=2)
        return result

    similarity, image = alike(part), alike(mirrored(part))
    near = _near(full, there[nodes])
    here, image_here = (np.where(near, each, -1.0).max(axis=1) for each in (similarity, image))
    lack = similarity.max(axis=1) - here
    more_alike = (similarity > here[:, None]).mean(axis=1)
    weights = _areas(part)[chosen]
    return Likeness(
        lack=float(np.average(lack, weights=weights)),
        leading=float(np.average(more_alike < 1.0 / LEADING, weights=weights)),
        handed=float(np.average(here > image_here, weights=weights)),
    )


def handed_by_relief(question: Question, there: Floats, own: Bools) -> float | None:
    """The same share of nodes whose places are more alike than mirrored, by the relief of the skin.

    Patches are compared as far as both are seen, so the full shape need not be hidden beyond what
    is shared. None where so little is shared that nothing can be said.
    """
    full, part = question.full, question.part
    chosen = _chosen(part, own)
    if len(chosen) < LEAST_NODES:
        return None
    nodes, labels = part.sparse.vertices[chosen], full.label_patches
    patches = part.patches_at_within(nodes, own)
    # only what is near says anything here, a hundredth of all places
    node, label = np.nonzero(_near(full, there[nodes])[:, labels.cells])

    def alike(own_patches: ReliefPatches) -> Singles:
        found = np.zeros(len(nodes), dtype=np.float32)
        pairs = patch_similarity_in_pairs(labels.patches[label], own_patches[node])
        np.maximum.at(found, node, pairs)
        return found

    handed = alike(patches) > alike(patches.mirrored())
    return float(np.average(handed, weights=_areas(part)[chosen]))


def recognized_by_relief(question: Question, there: Floats, own: Bools) -> float | None:
    """The share of nodes whose places are recognized among all labels, by the relief of the skin.

    Of one's own skin that is more than a half and of another's less, rightly laid or not: limbs on
    other limbs of one body are recognized there as well. None where so little is shared that
    nothing can be said.
    """
    full, part = question.full, question.part
    chosen = _chosen(part, own)
    if len(chosen) < LEAST_NODES:
        return None
    nodes, labels = part.sparse.vertices[chosen], full.label_patches
    similarity = patch_similarity(
        labels.patches, part.patches_at_within(nodes, own), labels.cells, len(full.dense)
    ).max(axis=2)
    here = np.where(_near(full, there[nodes]), similarity, -1.0).max(axis=1)
    more_alike = (similarity > here[:, None]).mean(axis=1)
    recognized = more_alike < MORE_ALIKE / len(np.unique(labels.cells))
    return float(np.average(recognized, weights=_areas(part)[chosen]))


def _chosen(part: DescribedSurface, own: Bools) -> Ints:
    """Nodes (q,) in what is shared, far from each other if not all."""
    order = part.sparse.farthest_first
    return order[own[part.sparse.vertices[order]]][:MOST_NODES]


def _areas(part: DescribedSurface) -> Floats:
    """(k,) of the cells of nodes."""
    counts = np.bincount(part.sparse.cells, part.mesh.vertex_areas, minlength=len(part.sparse))
    return counts.astype(np.float64, copy=False)


def _near(full: DescribedSurface, there: Floats) -> Bools:
    """(q, s) which labels lie at places (q, 3), give or take SAME_PLACE."""
    place = full.dense.cells[full.vertex_tree.query(there)[1]]
    near: Bools = full.dense.between[place] < SAME_PLACE
    return near


def mean_likeness(one: Likeness | None, other: Likeness | None) -> Likeness | None:
    """Mean of both directions; None where either says nothing."""
    if one is None or other is None:
        return None
    return Likeness(
        lack=0.5 * (one.lack + other.lack),
        leading=0.5 * (one.leading + other.leading),
        handed=0.5 * (one.handed + other.handed),
    )
