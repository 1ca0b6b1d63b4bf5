"""Blender extension: match a piece (selected) with the whole (active) by the `sherd` command.

The match runs in a process of its own, so Blender needs no package of sherd's, and stays usable
meanwhile. The vertices of both objects keep their numbers.
"""

# No `from __future__ import annotations` here: Blender reads the properties of a class from the
# values of its annotations.
import shutil
import subprocess
import tempfile
from pathlib import Path

import bpy

from . import exchange

COLORS = "sherd_correspondence"
CONFIDENCE, UNMATCHED, REGION = "sherd_confidence", "sherd_unmatched", "sherd_region"
SECONDS_BETWEEN_LOOKS = 0.5


class Job:
    """A running match of two objects, and its temporary folder."""

    def __init__(self, settings, full, part):
        self.full, self.part = full.name, part.name
        self.folder = Path(tempfile.mkdtemp(prefix="sherd_"))
        try:
            exchange.write_ply(self.folder / "full.ply", *world_mesh(full))
            exchange.write_ply(self.folder / "part.ply", *world_mesh(part))
            program = bpy.path.abspath(settings.command) if settings.command else ""
            words = exchange.match_command(program, self.folder, scale=settings.scale)
            with (self.folder / "errors.txt").open("wb") as errors:
                self.process = subprocess.Popen(
                    words, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=errors
                )
        except BaseException:
            self.clean()
            raise

    def answer(self):
        """What came out; waits for it. Raises ValueError or OSError if nothing did."""
        code = self.process.wait()
        errors = (self.folder / "errors.txt").read_text(encoding="utf-8", errors="replace")
        reason = exchange.failure(code, errors)
        if reason is not None:
            raise ValueError(reason)
        return exchange.read_answer(self.folder / "out")

    def objects(self):
        """Full shape and part, by name: Undo may have replaced them. Raises ValueError."""
        found = [bpy.data.objects.get(name) for name in (self.full, self.part)]
        if None in found:
            raise ValueError("an object was removed or renamed during the match")
        return found

    def stop(self):
        """End the match without an answer."""
        self.process.terminate()
        self.process.wait()

    def clean(self):
        """Remove the temporary folder."""
        shutil.rmtree(self.folder, ignore_errors=True)


def world_mesh(thing):
    """Vertices and triangles of an object as it stands in the scene, without its modifiers."""
    mesh, world = thing.data, thing.matrix_world
    mesh.calc_loop_triangles()
    # a mirrored object would be inside out
    step = -1 if world.determinant() < 0 else 1
    vertices = [tuple(world @ vertex.co) for vertex in mesh.vertices]
    return vertices, [tuple(triangle.vertices)[::step] for triangle in mesh.loop_triangles]


def chosen_pair(context):
    """The full shape (active) and the part (the other selected one), or None."""
    full = context.active_object
    others = [thing for thing in context.selected_objects if thing is not full]
    pair = [full, *others]
    if len(pair) != 2 or any(thing is None or thing.type != "MESH" for thing in pair):
        return None
    return tuple(pair) if full.select_get() and full.mode == "OBJECT" else None


def show_answer(answer, full, part):
    """Put colors and vertex groups on both objects.

    Raises ValueError if an object was edited since the match began.
    """
    counts = (len(full.data.vertices), len(part.data.vertices))
    if counts != (len(answer.region), len(answer.confidence)):
        raise ValueError("an object was edited during the match; match again")
    paint(full.data, answer.full_colors)
    paint(part.data, answer.part_colors)
    pairs = zip(answer.confidence, answer.matched, strict=True)
    set_group(part, CONFIDENCE, [value if known else 0.0 for value, known in pairs])
    set_group(part, UNMATCHED, [float(not known) for known in answer.matched])
    set_group(full, REGION, [float(inside) for inside in answer.region])


def paint(mesh, colors):
    """Colors of the vertices as the active color attribute."""
    old = mesh.color_attributes.get(COLORS)
    if old is not None:
        mesh.color_attributes.remove(old)
    attribute = mesh.color_attributes.new(COLORS, "BYTE_COLOR", "POINT")
    attribute.data.foreach_set("color_srgb", exchange.flattened(colors))
    mesh.color_attributes.active_color = mesh.color_attributes[COLORS]
    mesh.color_attributes.render_color_index = mesh.color_attributes.active_color_index
    mesh.update()


def set_group(thing, name, weights):
    """A vertex group with these weights; vertices of weight 0 are not in it."""
    old = thing.vertex_groups.get(name)
    if old is not None:
        thing.vertex_groups.remove(old)
    group = thing.vertex_groups.new(name=name)
    for vertex, weight in enumerate(weights):
        if weight > 0:
            group.add([vertex], weight, "REPLACE")


class SherdSettings(bpy.types.PropertyGroup):
    """What the panel asks for; kept in the file."""

    command: bpy.props.StringProperty(
        name="Command",
        description="Path of the sherd command, for example /home/me/venv/bin/sherd",
        subtype="FILE_PATH",
    )
    scale: bpy.props.EnumProperty(
        name="Scale",
        description="Whether the piece is of the size of the whole",
        items=[
            ("same", "Same", "The piece has the scale of the whole"),
            ("unknown", "Unknown", "The scale is estimated, whatever the units"),
        ],
    )


class OBJECT_OT_sherd_match(bpy.types.Operator):
    """Match the selected piece with the active object, which is the whole."""

    bl_idname = "object.sherd_match"
    bl_label = "Match piece with whole"
    bl_options = {"REGISTER", "UNDO"}

    _job = None
    _timer = None

    @classmethod
    def poll(cls, context):
        """Whether two meshes are selected."""
        return chosen_pair(context) is not None

    def execute(self, context):
        """Wait for the match; for scripts."""
        return self._finish(context) if self._start(context) else {"CANCELLED"}

    def invoke(self, context, _event):
        """Match while Blender goes on; Escape gives up."""
        if not self._start(context):
            return {"CANCELLED"}
        window = context.window_manager
        self._timer = window.event_timer_add(SECONDS_BETWEEN_LOOKS, window=context.window)
        window.modal_handler_add(self)
        context.workspace.status_text_set("sherd is matching; Escape gives up")
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        """Look whether the match is done."""
        if event.type == "ESC":
            self._job.stop()
            self._end(context)
            return {"CANCELLED"}
        if event.type == "TIMER" and self._job.process.poll() is not None:
            return self._finish(context)
        return {"PASS_THROUGH"}

    def cancel(self, context):
        """Blender is closed or another file opened."""
        self._job.stop()
        self._end(context)

    def _start(self, context):
        try:
            self._job = Job(context.scene.sherd, *chosen_pair(context))
        except (OSError, ValueError) as error:
            self.report({"ERROR"}, f"sherd cannot be started: {error}")
            return False
        return True

    def _finish(self, context):
        job = self._job
        try:
            answer = job.answer()
            show_answer(answer, *job.objects())
        except (OSError, ValueError) as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        finally:
            self._end(context)
        missing = answer.matched.count(False)
        said = f"{missing} of {len(answer.matched)} vertices unmatched; {answer.advice}"
        self.report({"WARNING"} if answer.doubtful else {"INFO"}, said)
        return {"FINISHED"}

    def _end(self, context):
        if self._timer is not None:
            context.window_manager.event_timer_remove(self._timer)
            context.workspace.status_text_set(None)
            self._timer = None
        self._job.clean()


class VIEW3D_PT_sherd(bpy.types.Panel):
    """The tab "sherd" of the sidebar."""

    bl_label = "sherd"
    bl_category = "sherd"
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"

    def draw(self, context):
        """Command, scale, the chosen pair and the button."""
        layout, settings = self.layout, context.scene.sherd
        layout.prop(settings, "command")
        layout.prop(settings, "scale")
        pair = chosen_pair(context)
        if pair is None:
            layout.label(text="Select the piece, then the whole", icon="INFO")
        else:
            layout.label(text=f"Whole: {pair[0].name}")
            layout.label(text=f"Piece: {pair[1].name}")
        layout.operator(OBJECT_OT_sherd_match.bl_idname)


CLASSES = (SherdSettings, OBJECT_OT_sherd_match, VIEW3D_PT_sherd)


def register():
    """Called by Blender when the extension is enabled."""
    for each in CLASSES:
        bpy.utils.register_class(each)
    bpy.types.Scene.sherd = bpy.props.PointerProperty(type=SherdSettings)


def unregister():
    """Called by Blender when the extension is disabled."""
    del bpy.types.Scene.sherd
    for each in reversed(CLASSES):
        bpy.utils.unregister_class(each)
