//! `[method]`: the method in force, its keys, and the keys of others.

use super::error::Error;
use super::keys::{METHODS, all_method_keys, belongs, owners};
use super::settings::{
    BlendedSplats, Brightness, Density, DiscShape, Discs, Falloff, Hybrid, ImageSpace, Interpolated, LongLists,
    MAX_ENSEMBLES, MAX_ITERATIONS, MAX_K, MAX_LAYERS, MAX_POINT_LAYERS, MAX_SAMPLES, MAX_SHELLS, Method, MethodChoice,
    OneLayer, Peel, PeelLayers, Raster, ScreenSplats, Shells, Soft, SoftLayout, Spbr, SpbrSimplified, SplatShape,
    Stochastic,
};
use super::table::{Range, Table};
use super::tree::Value;
use crate::words::nearest;

/// Reads the table; keys of other methods become warnings.
pub(super) fn read(table: &Table<'_>, warnings: &mut Vec<String>) -> Result<MethodChoice, Error> {
    table.refuse_unknown(&all_method_keys())?;
    let name = name(table)?;
    if let (Some(softness), true) = (table.get("softness"), table.get("lambda").is_some()) {
        let problem =
            "`method.lambda` and `method.softness` are both given, one follows from the other: keep one".into();
        return Err(Error::Conflict { place: softness.place.clone(), problem });
    }
    for (key, place) in table.keys().filter(|(key, _)| *key != "name" && !belongs(name, key)) {
        warnings.push(format!("{place}: method {name:?} does not use `{key}` (a key of {})", owners(key).join(", ")));
    }
    let method = match name {
        "points" => Method::Points,
        "squares" => Method::Squares(splats(table)?),
        "circles" => Method::Circles(splats(table)?),
        "paraboloid" => Method::Paraboloid(interpolated(table)?),
        "cone" => Method::Cone(interpolated(table)?),
        "sphere" => Method::Sphere(splats(table)?),
        "abuffer" => Method::ABuffer(discs(table)?),
        "linked-list" => Method::LinkedList(discs(table)?),
        "sorted" => Method::Sorted(discs(table)?),
        "peel" => Method::Peel(peel(table)?),
        "stochastic" => Method::Stochastic(stochastic(table)?),
        "hybrid" => Method::Hybrid(hybrid(table)?),
        "weighted" => Method::Weighted(discs(table)?),
        "average" => Method::Average(discs(table)?),
        "unsorted" => Method::Unsorted(discs(table)?),
        "hqs" => Method::Hqs(BlendedSplats { shape: outline(table)?, ..blended(table)? }),
        "splats" => Method::Splats(blended(table)?),
        "soft-base" => Method::SoftBase(soft(table)?),
        "soft-concentric" => Method::SoftConcentric(soft(table)?),
        "soft-express" => Method::SoftExpress(soft(table)?),
        "one-layer" => Method::OneLayer(one_layer(table)?),
        "image-space" => Method::ImageSpace(filters(table, ImageSpace::default())?),
        "peel-layers" => Method::PeelLayers(peel_layers(table)?),
        "spbr" => Method::Spbr(spbr(table)?),
        "spbr-simplified" => Method::SpbrSimplified(spbr_simplified(table)?),
        _ => {
            let choice = MethodChoice::Auto(discs(table)?);
            warn_of_shape(table, &choice, warnings);
            return Ok(choice);
        }
    };
    warn_of_shape(table, &method.into(), warnings);
    let in_vain = method.raster() == Raster::Hardware && method.is_tiled() && !matches!(method, Method::Stochastic(_));
    if let (true, Some(node)) = (in_vain, table.get("raster")) {
        let place = &node.place;
        warnings.push(format!("{place}: method {name:?} always works in compute shaders: `raster` has no effect"));
    }
    Ok(method.into())
}

fn name<'a>(table: &Table<'a>) -> Result<&'a str, Error> {
    let (Some(name), Some(node)) = (table.string("name")?, table.get("name")) else { return Ok("auto") };
    let place = node.place.clone();
    if METHODS.contains(&name) {
        Ok(name)
    } else {
        Err(Error::UnknownMethod {
            place,
            name: name.to_owned(),
            hint: nearest(name, METHODS.iter().copied(), "this version has"),
        })
    }
}

fn splats(table: &Table<'_>) -> Result<ScreenSplats, Error> {
    let default = ScreenSplats::default();
    Ok(ScreenSplats {
        size: table.number32("size", Range::NOT_NEGATIVE)?.unwrap_or(default.size),
        max_pixel_radius: table.number32("max_pixel_radius", Range::NOT_NEGATIVE)?.unwrap_or(default.max_pixel_radius),
        raster: raster(table)?,
    })
}

fn interpolated(table: &Table<'_>) -> Result<Interpolated, Error> {
    Ok(Interpolated { splats: splats(table)?, shape: outline(table)? })
}

fn outline(table: &Table<'_>) -> Result<SplatShape, Error> {
    shape(table, &OUTLINES, &DISC_SHAPES)
}

/// `shape` as opaque splats have it, and as transparent discs.
const OUTLINES: [(&str, SplatShape); 2] = [("circle", SplatShape::Circle), ("square", SplatShape::Square)];
const DISC_SHAPES: [(&str, DiscShape); 2] = [("flat", DiscShape::Flat), ("oriented", DiscShape::Oriented)];

/// A shape of the method in force; the default for one of the others, which is what a file has whose method was changed.
fn shape<T: Copy + Default, U>(table: &Table<'_>, own: &[(&str, T)], others: &[(&str, U)]) -> Result<T, Error> {
    if is_word(table, others) {
        return Ok(T::default());
    }
    Ok(table.choice("shape", own)?.unwrap_or_default())
}

fn is_word<T>(table: &Table<'_>, words: &[(&str, T)]) -> bool {
    match table.get("shape").map(|node| &node.value) {
        Some(Value::String(found)) => words.iter().any(|(word, _)| word == found),
        _ => false,
    }
}

/// Warns of a shape that only others have.
fn warn_of_shape(table: &Table<'_>, choice: &MethodChoice, warnings: &mut Vec<String>) {
    let method = choice.representative();
    let outlined = matches!(method, Method::Paraboloid(_) | Method::Cone(_) | Method::Hqs(_));
    let discs = method.discs().is_some();
    let foreign = (outlined && is_word(table, &DISC_SHAPES)) || (discs && is_word(table, &OUTLINES));
    if let (true, Some(node)) = (foreign, table.get("shape")) {
        let (place, name) = (&node.place, choice.name());
        let own = if outlined { "\"circle\" and \"square\"" } else { "\"flat\" and \"oriented\"" };
        warnings.push(format!("{place}: this `shape` is of other methods: {name:?} has {own}, and takes the first"));
    }
}

fn raster(table: &Table<'_>) -> Result<Raster, Error> {
    let rasters = [("auto", Raster::Auto), ("compute", Raster::Compute), ("hardware", Raster::Hardware)];
    Ok(table.choice("raster", &rasters)?.unwrap_or_default())
}

fn discs(table: &Table<'_>) -> Result<Discs, Error> {
    let falloffs = [("flat", Falloff::Flat), ("gaussian", Falloff::Gaussian)];
    let long_lists = [("merge", LongLists::Merge), ("in-place", LongLists::InPlace)];
    Ok(Discs {
        shape: shape(table, &DISC_SHAPES, &OUTLINES)?,
        falloff: table.choice("falloff", &falloffs)?.unwrap_or_default(),
        raster: raster(table)?,
        long_lists: table.choice("long_lists", &long_lists)?.unwrap_or_default(),
    })
}

fn peel(table: &Table<'_>) -> Result<Peel, Error> {
    Ok(Peel { discs: discs(table)?, layers: table.integer("layers", 0, MAX_LAYERS)?.unwrap_or_default() })
}

fn stochastic(table: &Table<'_>) -> Result<Stochastic, Error> {
    let default = Stochastic::default();
    Ok(Stochastic {
        discs: discs(table)?,
        samples: table.integer("samples", 1, MAX_SAMPLES)?.unwrap_or(default.samples),
        alpha_correction: table.boolean("alpha_correction")?.unwrap_or(default.alpha_correction),
    })
}

fn hybrid(table: &Table<'_>) -> Result<Hybrid, Error> {
    Ok(Hybrid { discs: discs(table)?, k: table.integer("k", 1, MAX_K)?.unwrap_or(Hybrid::default().k) })
}

fn blended(table: &Table<'_>) -> Result<BlendedSplats, Error> {
    let default = BlendedSplats::default();
    let blend_depth = table.number32("blend_depth", Range::NOT_NEGATIVE)?.unwrap_or(default.blend_depth);
    Ok(BlendedSplats { splats: splats(table)?, blend_depth, ..default })
}

fn soft(table: &Table<'_>) -> Result<Soft, Error> {
    let default = Soft::default();
    let softness = table.number32("softness", Range::UNIT)?.map(Density::Softness);
    let lambda = table.number32("lambda", Range::NOT_NEGATIVE)?.map(Density::Lambda);
    let threshold = table.number32("threshold", Range::UNIT)?.unwrap_or(default.threshold);
    let modulation = table.number32("modulation", Range::UNIT)?;
    if let (Some(most), Some(node)) = (modulation.filter(|most| *most <= threshold), table.get("modulation")) {
        let problem = format!("`method.modulation` must lie above `method.threshold`, found {most} and {threshold}");
        return Err(Error::Conflict { place: node.place.clone(), problem });
    }
    let layouts = [("precise", SoftLayout::Precise), ("paper", SoftLayout::Paper)];
    let layout = table.choice("layout", &layouts)?.unwrap_or_default();
    if let (SoftLayout::Paper, Some(_), Some(node)) = (layout, modulation, table.get("modulation")) {
        let problem = "`method.layout = \"paper\"` has no room for what `method.modulation` needs: keep one".into();
        return Err(Error::Conflict { place: node.place.clone(), problem });
    }
    Ok(Soft {
        threshold,
        density: softness.or(lambda).unwrap_or(default.density),
        modulation,
        shells: shells(table)?,
        pixels_per_shell: table.number32("pixels_per_shell", Range::POSITIVE)?.unwrap_or(default.pixels_per_shell),
        layout,
    })
}

fn shells(table: &Table<'_>) -> Result<Shells, Error> {
    match table.get("shells").map(|node| &node.value) {
        Some(Value::String(_)) => Ok(table.choice("shells", &[("adaptive", Shells::Adaptive)])?.unwrap_or_default()),
        _ => Ok(table.integer("shells", 1, MAX_SHELLS)?.map_or(Shells::Adaptive, Shells::Fixed)),
    }
}

fn one_layer(table: &Table<'_>) -> Result<OneLayer, Error> {
    let default = OneLayer::default();
    Ok(OneLayer {
        threshold: table.number32("threshold", Range::UNIT)?.unwrap_or(default.threshold),
        softness: table.number32("softness", Range::UNIT)?.unwrap_or(default.softness),
    })
}

fn filters(table: &Table<'_>, default: ImageSpace) -> Result<ImageSpace, Error> {
    let iterations = |key, default| Ok::<_, Error>(table.integer(key, 0, MAX_ITERATIONS)?.unwrap_or(default));
    Ok(ImageSpace {
        fill: iterations("fill", default.fill)?,
        occlusion: iterations("occlusion", default.occlusion)?,
        smooth: iterations("smooth", default.smooth)?,
        antialias: table.boolean("antialias")?.unwrap_or(default.antialias),
        antialias_threshold: table.number32("antialias_threshold", Range::UNIT)?.unwrap_or(default.antialias_threshold),
        min_layer_distance: table.number32("min_layer_distance", Range::POSITIVE)?,
        cull: table.boolean("cull")?.unwrap_or(default.cull),
    })
}

fn peel_layers(table: &Table<'_>) -> Result<PeelLayers, Error> {
    let default = PeelLayers::default();
    Ok(PeelLayers {
        filters: filters(table, default.filters)?,
        layers: table.integer("layers", 1, MAX_POINT_LAYERS)?.unwrap_or(default.layers),
    })
}

fn spbr(table: &Table<'_>) -> Result<Spbr, Error> {
    let default = Spbr::default();
    Ok(Spbr {
        ensembles: table.integer("ensembles", 1, MAX_ENSEMBLES)?.unwrap_or(default.ensembles),
        cos_theta: table.boolean("cos_theta")?.unwrap_or(default.cos_theta),
        brighten: table.boolean("brighten")?.unwrap_or(default.brighten),
    })
}

fn spbr_simplified(table: &Table<'_>) -> Result<SpbrSimplified, Error> {
    let default = SpbrSimplified::default();
    let brightness = match table.get("brightness").map(|node| &node.value) {
        Some(Value::String(_)) => table.choice("brightness", &[("auto", Brightness::Auto)])?,
        _ => table.number32("brightness", Range::POSITIVE)?.map(Brightness::Factor),
    };
    Ok(SpbrSimplified {
        ensembles: table.integer("ensembles", 1, MAX_ENSEMBLES)?.unwrap_or(default.ensembles),
        brightness: brightness.unwrap_or(default.brightness),
    })
}
