"""What Blender makes of a GLB with a morph target: python blender.py FILE VERTEX."""

from __future__ import annotations

import importlib
import json
import sys


def main(file: str, vertex: int) -> None:
    """Print what was read as JSON."""
    bpy = importlib.import_module("bpy")
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.import_scene.gltf(filepath=file)
    (shape,) = (thing for thing in bpy.data.objects if thing.type == "MESH")
    keys = shape.data.shape_keys.key_blocks
    picture = shape.data.uv_layers[0].data
    corners = [loop.index for loop in shape.data.loops if loop.vertex_index == vertex]
    read = {
        "count": len(shape.data.vertices),
        "keys": {key.name: key.value for key in keys},
        "at 0": list(keys[0].data[vertex].co),
        "at 1": list(keys["fit"].data[vertex].co),
        "uv": [list(picture[corner].uv) for corner in corners],
    }
    sys.stdout.write("\n" + json.dumps(read) + "\n")


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]))
