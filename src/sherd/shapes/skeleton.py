# ruff: noqa: E501 (a table is easier to read in long lines)
"""The animal's skeleton: bones, their flesh, and the poses as joint angles.

The animal stands along +x (nose forward), +y is its left, +z is up; it is about 1.5 long.
Angles are in degrees, right-handed about the axes of the standing animal: about y a bone that
points down swings backward and one that points forward turns down; about z it turns left.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from sherd.arrays import Floats

__all__ = ["BONES", "FLESH", "LANDMARKS", "POSES", "SEGMENTS", "Bone", "bone_frames", "rest_joints"]


@dataclass(frozen=True)
class Bone:
    """A bone from its joint along `vector`; the joint lies `offset` from the parent's far end."""

    name: str
    parent: str
    vector: tuple[float, float, float]
    radii: tuple[float, float]
    segment: str
    offset: tuple[float, float, float] = (0.0, 0.0, 0.0)


# fmt: off
# Left and right differ on purpose: the stance of all four legs, the ears, and the tail that
# hangs to the left, so that an individual and its mirror image can be told apart.
BONES = (
    Bone("loin", "", (0.22, 0.0, 0.01), (0.135, 0.125), "trunk", (-0.02, 0.0, 0.66)),
    Bone("chest", "loin", (0.22, 0.0, 0.02), (0.135, 0.135), "trunk"),
    Bone("pelvis", "", (-0.24, 0.0, 0.0), (0.130, 0.120), "trunk", (-0.02, 0.0, 0.66)),
    Bone("neck_low", "chest", (0.12, 0.0, 0.14), (0.100, 0.078), "neck", (0.0, 0.0, 0.02)),
    Bone("neck_high", "neck_low", (0.09, 0.0, 0.13), (0.076, 0.070), "neck"),
    Bone("head", "neck_high", (0.26, 0.012, -0.07), (0.082, 0.046), "head", (0.02, 0.0, 0.02)),
    Bone("left_ear", "head", (-0.03, 0.050, 0.150), (0.036, 0.022), "head", (-0.27, 0.036, 0.125)),
    Bone("right_ear", "head", (-0.075, -0.065, 0.110), (0.036, 0.022), "head", (-0.27, -0.060, 0.120)),
    Bone("tail_1", "pelvis", (-0.13, 0.01, -0.02), (0.046, 0.032), "tail", (-0.07, 0.0, 0.055)),
    Bone("tail_2", "tail_1", (-0.10, 0.03, -0.09), (0.032, 0.027), "tail"),
    Bone("tail_3", "tail_2", (-0.05, 0.04, -0.12), (0.027, 0.025), "tail"),
    Bone("tail_4", "tail_3", (-0.02, 0.03, -0.12), (0.030, 0.018), "tail"),
    Bone("left_upper_arm", "chest", (0.030, 0.020, -0.250), (0.080, 0.052), "left_front_leg", (-0.08, 0.095, -0.08)),
    Bone("left_forearm", "left_upper_arm", (0.045, 0.005, -0.190), (0.050, 0.036), "left_front_leg"),
    Bone("left_hand", "left_forearm", (0.030, 0.000, -0.125), (0.036, 0.042), "left_front_leg"),
    Bone("right_upper_arm", "chest", (-0.030, -0.020, -0.255), (0.080, 0.052), "right_front_leg", (-0.08, -0.095, -0.08)),
    Bone("right_forearm", "right_upper_arm", (-0.035, -0.005, -0.190), (0.050, 0.036), "right_front_leg"),
    Bone("right_hand", "right_forearm", (0.010, 0.000, -0.125), (0.036, 0.042), "right_front_leg"),
    Bone("left_thigh", "pelvis", (0.020, 0.030, -0.240), (0.105, 0.060), "left_hind_leg", (0.03, 0.080, -0.06)),
    Bone("left_shin", "left_thigh", (-0.085, 0.005, -0.170), (0.056, 0.036), "left_hind_leg"),
    Bone("left_foot", "left_shin", (0.010, 0.000, -0.150), (0.035, 0.042), "left_hind_leg"),
    Bone("right_thigh", "pelvis", (0.100, -0.030, -0.225), (0.105, 0.060), "right_hind_leg", (0.03, -0.080, -0.06)),
    Bone("right_shin", "right_thigh", (-0.060, -0.005, -0.180), (0.056, 0.036), "right_hind_leg"),
    Bone("right_foot", "right_shin", (0.030, 0.000, -0.150), (0.035, 0.042), "right_hind_leg"),
)

# Soft parts: (bone that carries it, start and end from that bone's joint, radii).
FLESH = (
    ("loin", (0.06, 0.0, -0.055), (-0.10, 0.0, -0.020), (0.120, 0.110)),   # belly
    ("chest", (0.02, 0.0, -0.050), (0.22, 0.0, -0.030), (0.125, 0.105)),   # ribs and breast
    ("chest", (0.10, 0.0, 0.080), (0.24, 0.0, 0.070), (0.065, 0.075)),     # withers
    ("head", (0.04, 0.0, -0.045), (0.20, 0.01, -0.085), (0.056, 0.036)),   # jaw
    ("head", (-0.03, 0.0, 0.025), (0.05, 0.0, 0.025), (0.060, 0.060)),     # brow
    ("left_hand", (0.030, 0.0, -0.125), (0.060, 0.004, -0.128), (0.040, 0.034)),    # hooves
    ("right_hand", (0.010, 0.0, -0.125), (0.040, -0.004, -0.128), (0.040, 0.034)),
    ("left_foot", (0.010, 0.0, -0.150), (0.040, 0.004, -0.153), (0.040, 0.034)),
    ("right_foot", (0.030, 0.0, -0.150), (0.060, -0.004, -0.153), (0.040, 0.034)),
)

# The vertex farthest along a direction on the flesh of a bone.
LANDMARKS = {
    "nose": ("head", (1.0, 0.0, -0.2)),
    "left_ear_tip": ("left_ear", (-0.2, 0.35, 1.0)),
    "right_ear_tip": ("right_ear", (-0.5, -0.5, 1.0)),
    "tail_tip": ("tail_4", (-0.2, 0.2, -1.0)),
    "left_front_hoof": ("left_hand", (0.2, 0.0, -1.0)),
    "right_front_hoof": ("right_hand", (0.2, 0.0, -1.0)),
    "left_hind_hoof": ("left_foot", (0.2, 0.0, -1.0)),
    "right_hind_hoof": ("right_foot", (0.2, 0.0, -1.0)),
    "breast": ("chest", (1.0, 0.0, -0.7)),
    "back": ("loin", (0.0, 0.0, 1.0)),
}

# Joint angles (x, y, z) in degrees; bones not named keep their place on the parent. No joint turns
# by more than 34 degrees, so that about 95 % of the edges keep their length within 10 %.
POSES: dict[str, dict[str, tuple[float, float, float]]] = {
    "stand": {},
    "walk": {
        "neck_low": (0, 6, 5), "head": (0, 5, 6), "tail_1": (0, 0, -10), "tail_2": (0, 0, -10),
        "left_upper_arm": (0, 18, 0), "left_forearm": (0, 11, 0), "left_hand": (0, 8, 0),
        "right_upper_arm": (0, -19, 0), "right_forearm": (0, 6, 0), "right_hand": (0, 5, 0),
        "left_thigh": (0, -18, 0), "left_shin": (0, -5, 0), "left_foot": (0, 5, 0),
        "right_thigh": (0, 19, 0), "right_shin": (0, 6, 0), "right_foot": (0, 8, 0),
    },
    "gallop": {
        "loin": (0, -3, 0), "chest": (0, -4, 0), "pelvis": (0, -6, 0),
        "neck_low": (0, 12, 0), "neck_high": (0, 7, 0), "head": (0, -10, 0),
        "tail_1": (0, 16, 0), "tail_2": (0, 16, 0), "tail_3": (0, 15, 0), "tail_4": (0, 10, 0),
        "left_upper_arm": (0, -23, 0), "left_forearm": (0, -9, 0), "left_hand": (0, 6, 0),
        "right_upper_arm": (0, -18, 0), "right_forearm": (0, 16, 0), "right_hand": (0, 16, 0),
        "left_thigh": (0, 22, 0), "left_shin": (0, 10, 0), "left_foot": (0, 9, 0),
        "right_thigh": (0, 19, 0), "right_shin": (0, 15, 0), "right_foot": (0, 12, 0),
    },
    "graze": {
        "chest": (0, 6, 0), "neck_low": (0, 30, 5), "neck_high": (0, 29, 5), "head": (0, 9, 5),
        "tail_1": (0, -8, 8), "tail_2": (0, -5, 8),
        "left_upper_arm": (0, -17, 3), "left_forearm": (0, 0, 0),
        "right_upper_arm": (0, 8, -3), "right_forearm": (0, 3, 0),
        "left_thigh": (0, 8, 0), "right_thigh": (0, -6, 0),
    },
    "sit": {
        "loin": (0, -11, 0), "chest": (0, -10, 0), "pelvis": (0, -16, 0),
        "neck_low": (0, 3, 0), "neck_high": (0, 8, 0), "head": (0, 11, -6),
        "tail_1": (0, -11, 11), "tail_2": (0, -13, 10), "tail_3": (0, -11, 8),
        "left_thigh": (0, -29, 0), "left_shin": (0, 30, 0), "left_foot": (0, -21, 0),
        "right_thigh": (0, -24, 0), "right_shin": (0, 29, 0), "right_foot": (0, -24, 0),
        "left_upper_arm": (0, 18, 0), "right_upper_arm": (0, 19, 0),
    },
    "turn": {
        "loin": (0, 0, 10), "chest": (0, 0, 11), "pelvis": (0, 0, 10),
        "neck_low": (0, 5, 22), "neck_high": (0, 5, 22), "head": (0, 6, 18),
        "tail_1": (0, 24, 0), "tail_2": (0, 21, 8), "tail_3": (0, 18, 8), "tail_4": (0, 16, 0),
        "left_upper_arm": (0, -13, 0), "left_forearm": (0, 21, 0), "left_hand": (0, 16, 0),
        "right_thigh": (0, 11, 0),
    },
}
# fmt: on

SEGMENTS = tuple(dict.fromkeys(bone.segment for bone in BONES))

_INDEX = {bone.name: number for number, bone in enumerate(BONES)}


def rest_joints(scales: Floats) -> tuple[Floats, Floats]:
    """Joint and vector of each bone of the standing animal, (b, 3) l each.

    Parameters
    ----------
    scales
        (b,) length of each bone, with its offset, relative to the table.
    """
    joints, vectors = np.zeros((len(BONES), 3)), np.zeros((len(BONES), 3))
    for number, bone in enumerate(BONES):
        origin = np.zeros(3)
        if bone.parent:
            parent = _INDEX[bone.parent]
            origin = joints[parent] + vectors[parent]
        joints[number] = origin + scales[number] * np.array(bone.offset)
        vectors[number] = scales[number] * np.array(bone.vector)
    return joints, vectors


def bone_frames(joints: Floats, pose: str) -> tuple[Floats, Floats]:
    """Rotation (b, 3, 3) and shift (b, 3) that take each standing bone to its place in `pose`.

    `posed = rotation @ standing + shift`, each bone turning with its parent.
    """
    angles = POSES[pose]
    rotations, shifts = np.empty((len(BONES), 3, 3)), np.empty((len(BONES), 3))
    for number, bone in enumerate(BONES):
        above, carried = np.eye(3), joints[number]
        if bone.parent:
            parent = _INDEX[bone.parent]
            above = rotations[parent]
            carried = above @ joints[number] + shifts[parent]
        rotations[number] = above @ _turn(angles.get(bone.name, (0.0, 0.0, 0.0)))
        shifts[number] = carried - rotations[number] @ joints[number]
    return rotations, shifts


def _turn(degrees: tuple[float, float, float]) -> Floats:
    """Rotation about x, then y, then z."""
    (cx, cy, cz), (sx, sy, sz) = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    about_x = np.array([[1, 0, 0], [0, cx, -sx], [0, sx, cx]])
    about_y = np.array([[cy, 0, sy], [0, 1, 0], [-sy, 0, cy]])
    about_z = np.array([[cz, -sz, 0], [sz, cz, 0], [0, 0, 1]])
    rotation: Floats = about_z @ about_y @ about_x
    return rotation
