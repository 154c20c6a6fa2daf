"""The peer VTK: points as squares, offscreen.

Modes: `opaque` (depth test), `sorted` (vtkDepthSortPolyData, then blending), `peel100` (dual depth peeling with up to
100 peels, VTK's exact order-independent transparency).
"""

import numpy as np
import vtk
from vtk.util.numpy_support import numpy_to_vtk, vtk_to_numpy

from camera import FAR, NEAR, eye_at
from worker import arguments, run


def point_data(scene):
    """The scene's points as vertices with colors."""
    n = len(scene.positions)
    points, cells, data = vtk.vtkPoints(), vtk.vtkCellArray(), vtk.vtkPolyData()
    points.SetData(numpy_to_vtk(scene.positions, deep=1))
    # One cell per point: how many points it has, and which.
    ids = np.column_stack([np.ones(n, np.int64), np.arange(n)])
    cells.ImportLegacyFormat(numpy_to_vtk(ids.ravel(), deep=1, array_type=vtk.VTK_ID_TYPE))
    used = scene.colors[:, :3].copy() if scene.opaque else scene.colors
    colors = numpy_to_vtk(used, deep=1, array_type=vtk.VTK_UNSIGNED_CHAR)
    data.SetPoints(points)
    data.SetVerts(cells)
    data.GetPointData().SetScalars(colors)
    return data


def depth_sorted(data, camera):
    """A filter that sorts the vertices far to near whenever the camera has moved."""
    source, order = vtk.vtkTrivialProducer(), vtk.vtkDepthSortPolyData()
    source.SetOutput(data)
    order.SetInputConnection(source.GetOutputPort())
    order.SetCamera(camera)
    order.SetDirectionToBackToFront()
    order.SetDepthSortModeToFirstPoint()
    return order


def actor(scene, mode, camera):
    """Makes the actor that draws the points."""
    mapper, result = vtk.vtkPolyDataMapper(), vtk.vtkActor()
    data = point_data(scene)
    if mode == "sorted":
        # A port does not keep its filter alive; a connection does.
        order = depth_sorted(data, camera)
        mapper.SetInputConnection(order.GetOutputPort())
    else:
        mapper.SetInputData(data)
    result.SetMapper(mapper)
    result.GetProperty().SetPointSize(scene.size_px)
    result.GetProperty().LightingOff()
    if mode == "opaque":
        result.ForceOpaqueOn()
    else:
        result.ForceTranslucentOn()
    return result


def window(scene, mode):
    """An offscreen window with the scene in it, and its renderer."""
    renderer, result = vtk.vtkRenderer(), vtk.vtkRenderWindow()
    renderer.SetBackground(0, 0, 0)
    renderer.AddActor(actor(scene, mode, renderer.GetActiveCamera()))
    # Not weighted blending, which would take the place of plain blending.
    renderer.SetUseOIT(False)
    if mode == "peel100":
        renderer.SetUseDepthPeeling(1)
        renderer.SetMaximumNumberOfPeels(100)
        renderer.SetOcclusionRatio(0.0)
    result.SetOffScreenRendering(1)
    result.SetMultiSamples(0)
    result.SetSize(scene.view.width, scene.view.height_px)
    result.SetAlphaBitPlanes(1)
    result.AddRenderer(renderer)
    return result, renderer


def place(camera, view, frame):
    """Moves the camera to where it is in a frame."""
    camera.SetPosition(*eye_at(view, frame))
    camera.SetFocalPoint(*view.target)
    camera.SetViewUp(*view.up)
    if view.height:
        camera.ParallelProjectionOn()
        camera.SetParallelScale(view.height / 2)
    else:
        camera.SetViewAngle(view.fov_y)
    camera.SetClippingRange(NEAR, FAR)


def main():
    """Draws one scene."""
    scene, options = arguments(["opaque", "sorted", "peel100"])
    view = scene.view
    win, renderer = window(scene, options.mode)
    pixels = vtk.vtkUnsignedCharArray()

    def draw(frame):
        place(renderer.GetActiveCamera(), view, frame)
        win.Render()
        win.GetRGBACharPixelData(0, 0, view.width - 1, view.height_px - 1, 0, pixels)
        return vtk_to_numpy(pixels).reshape(view.height_px, view.width, 4)[::-1]

    def driver():
        lines = win.ReportCapabilities().splitlines()
        name = next((line.split(":", 1)[1].strip() for line in lines if line.startswith("OpenGL renderer")), "?")
        return f"{win.GetClassName()}, {name}"

    run(draw, options, "VTK " + vtk.vtkVersion.GetVTKVersion(), driver)


if __name__ == "__main__":
    main()
