"""Pictures by VTK's OpenGL renderer. Its targets have 8 bits."""

import numpy as np
import vtk
from vtk.util.numpy_support import numpy_to_vtk, vtk_to_numpy

from scene import DISTANCE, FAR, FOV, NEAR, SIZE, Disc

VERSION = f"VTK {vtk.vtkVersion().GetVTKVersion()}"
# Half the side of the quad that stands for a disc beyond the image.
SIDE = 6.0


def _plane(disc: Disc) -> vtk.vtkActor:
    """A square in the disc's plane."""
    source = vtk.vtkPlaneSource()
    source.SetOrigin(-SIDE, -SIDE, 0.0)
    source.SetPoint1(SIDE, -SIDE, 0.0)
    source.SetPoint2(-SIDE, SIDE, 0.0)
    source.SetCenter(0.0, 0.0, 0.0)
    source.SetNormal(*disc.normal)
    source.SetCenter(*disc.center)
    return _actor(source.GetOutputPort(), disc.color, disc.opacity)


def _actor(port: vtk.vtkAlgorithmOutput, color: tuple[float, float, float], opacity: float) -> vtk.vtkActor:
    """What an algorithm makes, in one color without light."""
    mapper = vtk.vtkPolyDataMapper()
    mapper.SetInputConnection(port)
    actor = vtk.vtkActor()
    actor.SetMapper(mapper)
    actor.GetProperty().SetColor(*color)
    actor.GetProperty().SetOpacity(opacity)
    actor.GetProperty().LightingOff()
    return actor


def _window(background: tuple[float, float, float]) -> tuple[vtk.vtkRenderWindow, vtk.vtkRenderer]:
    """A window off screen with the scenes' camera."""
    window = vtk.vtkRenderWindow()
    window.SetOffScreenRendering(1)
    window.SetSize(SIZE, SIZE)
    window.SetMultiSamples(0)
    window.SetAlphaBitPlanes(1)
    renderer = vtk.vtkRenderer()
    renderer.SetBackground(*background)
    window.AddRenderer(renderer)
    camera = renderer.GetActiveCamera()
    camera.SetPosition(0.0, 0.0, DISTANCE)
    camera.SetFocalPoint(0.0, 0.0, 0.0)
    camera.SetViewUp(0.0, 1.0, 0.0)
    camera.SetViewAngle(FOV)
    camera.SetClippingRange(NEAR, FAR)
    return window, renderer


def _read(window: vtk.vtkRenderWindow) -> np.ndarray:
    """The window's colors in [0, 1], rows from the top."""
    grab = vtk.vtkWindowToImageFilter()
    grab.SetInput(window)
    grab.ReadFrontBufferOff()
    grab.Update()
    values = vtk_to_numpy(grab.GetOutput().GetPointData().GetScalars())
    return values.reshape(SIZE, SIZE, 3)[::-1].astype(np.float64) / 255.0


def planes(discs: list[Disc], background: tuple[float, float, float]) -> np.ndarray:
    """Translucent planes by dual depth peeling, as many peels as it takes: (SIZE, SIZE, 3)."""
    window, renderer = _window(background)
    renderer.UseDepthPeelingOn()
    renderer.SetMaximumNumberOfPeels(100)
    renderer.SetOcclusionRatio(0.0)
    for disc in discs:
        renderer.AddActor(_plane(disc))
    window.Render()
    return _read(window)


def points(clouds: list[tuple[np.ndarray, tuple[float, float, float]]]) -> tuple[np.ndarray, np.ndarray]:
    """Opaque points of a pixel each: colors (SIZE, SIZE, 3), and depths along the view, +inf where nothing is."""
    window, renderer = _window((0.0, 0.0, 0.0))
    for positions, color in clouds:
        data = vtk.vtkPolyData()
        data.SetPoints(vtk.vtkPoints())
        data.GetPoints().SetData(numpy_to_vtk(np.ascontiguousarray(positions, dtype=np.float32), deep=True))
        cells = vtk.vtkVertexGlyphFilter()
        cells.SetInputData(data)
        actor = _actor(cells.GetOutputPort(), color, 1.0)
        actor.GetProperty().SetPointSize(1.0)
        renderer.AddActor(actor)
    window.Render()
    depth = vtk.vtkFloatArray()
    window.GetZbufferData(0, 0, SIZE - 1, SIZE - 1, depth)
    stored = vtk_to_numpy(depth).reshape(SIZE, SIZE)[::-1].astype(np.float64)
    along = NEAR * FAR / (FAR - stored * (FAR - NEAR))
    return _read(window), np.where(stored < 1.0, along, np.inf)
