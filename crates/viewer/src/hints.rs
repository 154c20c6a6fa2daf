//! What a key of the scene file does, in a sentence with its unit.

/// What a dotted key does; clouds are named by number or `*`. Empty for keys without a control.
pub fn hint(key: &str) -> &'static str {
    let (table, name) = key.split_once('.').unwrap_or(("", key));
    match table {
        "method" => of_method(name),
        "shading" => of_shading(name),
        "shadows" => of_shadows(name),
        "image" => of_image(name),
        "cloud" => of_cloud(name.split_once('.').map_or(name, |(_, name)| name)),
        _ => "",
    }
}

fn of_method(key: &str) -> &'static str {
    match key {
        "threshold" => "t: points with a field F above it are soft, the others solid (0 to 1)",
        "softness" => "opacity of a ray through the middle of a soft sphere of median radius (0 to 1)",
        "lambda" => "the density of soft spheres itself, as in the equations, instead of softness",
        "modulation" => "fields from t up to this fade in from transparent to the full density (above t, to 1)",
        "shells" => "soft-concentric: spheres that stand for a soft one; adaptive: by its radius in pixels",
        "pixels_per_shell" => "soft-concentric: how thick a shell is where shells are adaptive, in pixels",
        "layout" => "soft-base: what is stored of a fragment: precise, or the 16 bytes of the paper",
        "size" => "factor on the radius of splats",
        "max_pixel_radius" => "splats are no larger than this, in pixels",
        "blend_depth" => "what lies so many radii behind the nearest splat is blended with it",
        "samples" => "samples of each pixel: more have less noise and take longer",
        "alpha_correction" => "exact opacity, color scaled to it: less noise",
        "k" => "so many of the nearest fragments are exact, those behind are averaged",
        "layers" => "layers that are peeled and blended, the nearest ones (peel: 0 is all)",
        "ensembles" => "L: random parts of the points whose images are averaged",
        "cos_theta" => "slanted surfaces are more opaque",
        "brighten" => "makes the picture as bright as that of the opaque surfaces",
        "brightness" => "factor on the colors; auto: as bright as a single ensemble",
        "fill" => "how often background pixels between points are filled",
        "occlusion" => "how often points seen through holes are replaced",
        "smooth" => "how often the picture is smoothed",
        "antialias" => "blends the edges of surfaces",
        "antialias_threshold" => "share of an edge from which it is blended (0 to 1)",
        "min_layer_distance" => "surfaces are at least so far apart along the view, in world units",
        "cull" => "leaves out points that face away",
        "shape" => "oriented: discs in the tangent plane; flat, circle, square: they face the screen",
        "falloff" => "gaussian: opacity falls toward the rim",
        "long_lists" => "how long lists of fragments are sorted; the picture is the same",
        "raster" => "who visits pixels: compute shaders or the rasteriser",
        _ => "",
    }
}

fn of_shading(key: &str) -> &'static str {
    match key {
        "model" => "lambert: matt; phong: with highlights; none: the colors as they are",
        "ambient" => "light that is everywhere (factor on the color)",
        "diffuse" => "light by the angle to the normal (factor on the color)",
        "specular" => "strength of highlights (phong)",
        "shininess" => "how small highlights are (phong: exponent)",
        "light" => "at the eye, from afar along a direction, or at a place",
        "light.direction" => "the direction in which the light travels",
        "light.position" => "where the light is, in world units",
        "light.azimuth" => "where the light comes from, in degrees around the vertical from the front",
        "light.elevation" => "how high the light stands, in degrees above the horizon",
        _ => "",
    }
}

fn of_shadows(key: &str) -> &'static str {
    match key {
        "method" => "how much light reaches each point, past the others",
        "samples" => "lights that stand for one with an extent: more make smoother rims",
        "light_radius" => "extent of the light: degrees around a direction, world units around a place; 0: hard",
        "resolution" => "columns and rows of the light's image, in pixels",
        "min_layer_distance" => "points so near to the first lit surface are lit with it, in world units",
        _ => "",
    }
}

fn of_image(key: &str) -> &'static str {
    match key {
        "background" => "what is behind all points, linear",
        "color" => "in which space colors are blended: linear light, or encoded as they are stored",
        _ => "",
    }
}

fn of_cloud(key: &str) -> &'static str {
    match key {
        "opacity" => "how much a point's splat hides, for spbr a surface (0 to 1)",
        "color" => "one color instead of the file's",
        "radius" => "one radius for all points, in world units",
        "radius_factor" => "factor on the radii of all clouds",
        "neighbors" => "K: neighbors that radii and uncertainty are estimated from",
        "field" => "F: what tells soft points from solid ones",
        "soft_classes" => "points of these classes are soft",
        "axis.point" => "a point of the axis, in world units; else the middle of the cloud",
        "axis.direction" => "the direction of the axis; else the vertical",
        _ => "",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use pellucid_engine::scene::{METHODS, SHADING_KEYS, SHADOW_KEYS, method_keys};

    #[test]
    fn every_key_is_told() {
        let methods = METHODS.iter().flat_map(|name| method_keys(name)).map(|key| format!("method.{key}"));
        let shading = SHADING_KEYS.iter().map(|key| format!("shading.{key}"));
        let shadows = SHADOW_KEYS.iter().map(|key| format!("shadows.{key}"));
        let others = ["opacity", "color", "radius", "radius_factor", "neighbors", "field", "soft_classes"];
        let clouds = others.iter().flat_map(|key| [format!("cloud.12.{key}"), format!("cloud.*.{key}")]);
        for key in methods.chain(shading).chain(shadows).chain(clouds) {
            let said = hint(&key);
            assert!(!said.is_empty() && said.len() < 100, "{key}: {said:?}");
        }
        assert_eq!((hint("method.nonsense"), hint("cloud.0.path"), hint("camera")), ("", "", ""));
    }
}
