"""The peer vispy: point sprites through its `gloo`, offscreen, as discs that the caller sorts by depth for every frame.

Modes: `opaque` (depth test, no order), `sorted` (blended in 8 bits).
"""

import numpy as np
import vispy
from vispy import app, gloo

from camera import project, projection_matrix, view_matrix
from scenes import radius_px
from worker import arguments, run

VERTEX = """
uniform mat4 u_matrix;
uniform float u_size;
attribute vec3 a_position;
attribute vec4 a_color;
varying vec4 v_color;
void main() {
    gl_Position = u_matrix * vec4(a_position, 1.0);
    gl_PointSize = u_size;
    v_color = a_color;
}
"""
OPAQUE = """
varying vec4 v_color;
void main() { gl_FragColor = v_color; }
"""
DISC = """
varying vec4 v_color;
void main() {
    vec2 offset = 2.0 * gl_PointCoord - 1.0;
    if (dot(offset, offset) > 1.0) discard;
    gl_FragColor = v_color;
}
"""


def main():
    """Draws one scene."""
    scene, options = arguments(["opaque", "sorted"])
    view, opaque = scene.view, options.mode == "opaque"
    size = view.height_px, view.width
    app.use_app("egl")
    canvas = app.Canvas(size=(view.width, view.height_px), show=False)
    canvas.set_current()
    target = gloo.FrameBuffer(gloo.RenderBuffer((*size, 4)), gloo.RenderBuffer(size))
    program = gloo.Program(VERTEX, OPAQUE if opaque else DISC)
    program["a_position"] = scene.positions
    program["a_color"] = (scene.colors / 255.0).astype(np.float32)
    program["u_size"] = float(1 if opaque else 2 * radius_px(scene.size_px))
    indices = gloo.IndexBuffer(np.arange(len(scene.positions), dtype=np.uint32))
    gloo.set_state(
        depth_test=opaque, blend=not opaque, blend_func=("src_alpha", "one_minus_src_alpha"), clear_color="black"
    )

    def draw(frame):
        if not opaque:
            _, _, depth = project(scene.positions, view, frame, np.float32)
            indices.set_data(np.argsort(-depth, kind="stable").astype(np.uint32))
        # vispy takes matrices transposed.
        program["u_matrix"] = (projection_matrix(view) @ view_matrix(view, frame)).T.astype(np.float32)
        with target:
            gloo.set_viewport(0, 0, view.width, view.height_px)
            gloo.clear(color=True, depth=True)
            program.draw("points", None if opaque else indices)
            return target.read("color", alpha=True)

    run(draw, options, "vispy " + vispy.__version__, lambda: gloo.gl.glGetParameter(gloo.gl.GL_RENDERER))


if __name__ == "__main__":
    main()
