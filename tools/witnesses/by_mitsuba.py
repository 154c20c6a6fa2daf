"""Pictures by Mitsuba 3, a path tracer: alpha as a mask of materials, Gaussians along rays, absorbing media."""

import drjit as dr
import mitsuba as mi
import numpy as np

from scene import SIZE, Disc, Gaussian, rays

VERSION = f"Mitsuba {mi.__version__}"
mi.set_variant("llvm_ad_rgb")


# Rays that are traced at once.
PARCEL = 500


def _trace(scene: dict, integrator: dict, samples: int) -> np.ndarray:
    """Mean radiance of so many samples along the rays through the pixels' centers: (SIZE, SIZE, 3)."""
    loaded = mi.load_dict({"type": "scene", **scene})
    tracer = mi.load_dict(integrator)
    origin, directions = rays()
    total = np.zeros((SIZE, SIZE, 3))
    for first in range(0, samples, PARCEL):
        count = min(PARCEL, samples - first)
        flat = np.broadcast_to(directions, (count, SIZE, SIZE, 3)).reshape(-1, 3).T
        ray = mi.RayDifferential3f(mi.Point3f(*origin.tolist()), mi.Vector3f(flat))
        sampler = mi.load_dict({"type": "independent"})
        sampler.seed(first, flat.shape[1])
        if integrator["type"] == "volprim_rf_basic":
            # An integrator that is made to be differentiated.
            found = tracer.sample(dr.ADMode.Primal, loaded, sampler, ray, None, None, mi.Bool(True))[0]
        else:
            found = tracer.sample(loaded, sampler, ray)[0]
        total += np.array(found, dtype=np.float64).T.reshape(count, SIZE, SIZE, 3).sum(axis=0)
    return total / samples


def _background(color: tuple[float, float, float]) -> dict:
    """Light of one color from everywhere."""
    return {"type": "constant", "radiance": {"type": "rgb", "value": list(color)}}


def planes(discs: list[Disc], background: tuple[float, float, float], samples: int) -> np.ndarray:
    """Discs that glow in proportion to their opacity and let the rest through: (SIZE, SIZE, 3)."""
    scene: dict = {"background": _background(background)}
    for index, disc in enumerate(discs):
        center = mi.ScalarPoint3f(*disc.center)
        place = mi.ScalarTransform4f().look_at(center, center + mi.ScalarPoint3f(*disc.normal), mi.ScalarVector3f(0.0, 1.0, 0.1))
        scene[f"disc{index}"] = {
            "type": "disk",
            "to_world": place @ mi.ScalarTransform4f().scale(disc.radius),
            "light": {"type": "area", "radiance": {"type": "rgb", "value": [disc.opacity * value for value in disc.color]}},
            "material": {"type": "mask", "opacity": disc.opacity, "inner": {"type": "diffuse", "reflectance": 0.0}},
        }
    return _trace(scene, {"type": "path", "max_depth": -1, "rr_depth": 1000}, samples)


def gaussians(splats: list[Gaussian]) -> np.ndarray:
    """Gaussians along each ray, front to back, by `volprim_rf_basic`, which is deterministic: (SIZE, SIZE, 3)."""
    c0 = 0.28209479177387814
    colors = np.array([s.color for s in splats])
    shape = {
        "type": "ellipsoids",
        "centers": mi.TensorXf(np.array([s.center for s in splats], dtype=np.float32)),
        "scales": mi.TensorXf(np.array([s.scale for s in splats], dtype=np.float32)),
        # Real parts come last.
        "quaternions": mi.TensorXf(np.array([(*s.rotation[1:], s.rotation[0]) for s in splats], dtype=np.float32)),
        "opacities": mi.TensorXf(np.array([[s.opacity] for s in splats], dtype=np.float32)),
        "sh_coeffs": mi.TensorXf(((colors - 0.5) / c0).astype(np.float32)),
        # As many standard deviations as leave nothing that counts.
        "extent": 6.0,
    }
    return _trace({"splats": shape}, {"type": "volprim_rf_basic"}, 1)


def soft_sphere(center: tuple[float, float, float], radius: float, scale: float, samples: int) -> np.ndarray:
    """White light through a sphere of density scale · (radius − distance from its center): (SIZE, SIZE, 3)."""
    side = 160
    steps = (np.arange(side) + 0.5) / side * 2.0 - 1.0
    z, y, x = np.meshgrid(steps, steps, steps, indexing="ij")
    density = np.maximum(0.0, 1.0 - np.sqrt(x * x + y * y + z * z)) * radius
    box = mi.ScalarTransform4f().translate(mi.ScalarPoint3f(*center)).scale(radius)
    grid = {
        "type": "gridvolume",
        "grid": mi.VolumeGrid(density.astype(np.float32)[..., None]),
        "to_world": box @ mi.ScalarTransform4f().translate([-1, -1, -1]).scale(2.0),
    }
    medium = {"type": "heterogeneous", "albedo": 0.0, "sigma_t": grid, "scale": scale}
    cube = {"type": "cube", "to_world": box, "interior": medium, "material": {"type": "null"}}
    scene = {"background": _background((1.0, 1.0, 1.0)), "cube": cube}
    return _trace(scene, {"type": "volpath", "max_depth": -1, "rr_depth": 1000}, samples)
