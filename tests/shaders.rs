//! Every shader and variant parses, validates and agrees with its Rust declaration. No device is needed.

use pellucid_engine::gpu::shader::{self, WORKGROUP};
use pellucid_engine::gpu::{Agree, Pass, Variant};
use pellucid_engine::methods::approximate::{OneRun, Round};
use pellucid_engine::methods::image_space::{Filter, Listed};
use pellucid_engine::methods::soft::express::{self, Way};
use pellucid_engine::methods::soft::{self, Interior, Kind};
use pellucid_engine::methods::spbr::{self, Stage};
use pellucid_engine::methods::stochastic::hardware;
use pellucid_engine::methods::{
    abuffer, approximate, image_space, linked_list, one_layer, peel, peel_layers, points, shadows, sorted, splat,
    splats, stochastic,
};
use pellucid_engine::passes::bin::{self, Order};
use pellucid_engine::passes::compose::{self, Cut};
use pellucid_engine::passes::project::{self, Footprint, Part, Projecting};
use pellucid_engine::passes::{radix, raster, scan, tiles};
use pellucid_engine::scene::{ColorSpace, Falloff, Relief, Shading, ShadingModel, Shells};
use pellucid_engine::{SHADERS, gpu_struct, pass};

/// Sizes of subgroups that a device may have.
const SUBGROUPS: [u32; 4] = [4, 8, 16, 32];
const FOOTPRINTS: [Footprint; 4] = [Footprint::Disc, Footprint::Oriented, Footprint::Square, Footprint::Point];

fn check<P: Pass>(seen: &mut Vec<&'static str>, variants: impl IntoIterator<Item = Variant>) {
    for variant in variants {
        shader::check::<P>(&variant).unwrap_or_else(|e| panic!("{} {variant:?}: {e}", P::NAME));
    }
    seen.push(P::SHADER);
}

fn raster_variants() -> Vec<Variant> {
    FOOTPRINTS.iter().flat_map(|f| raster::WALKERS.map(|w| raster::variant(*f, w))).collect()
}

fn relief_variants() -> Vec<Variant> {
    let reliefs = [Relief::Flat, Relief::Paraboloid, Relief::Cone, Relief::Sphere];
    reliefs.iter().flat_map(|r| raster_variants().into_iter().map(|v| splat::relief_variant(v, *r))).collect()
}

/// All ways to shade.
fn projectings(footprint: Footprint) -> Vec<Projecting> {
    let models = [ShadingModel::None, ShadingModel::Lambert, ShadingModel::Phong];
    let of = |model, color, part, lit| {
        let shading = Shading { model, ..Shading::default() };
        Projecting {
            footprint,
            radius_factor: 1.0,
            max_radius_px: f32::MAX,
            opacity_factor: 1.0,
            part,
            relative_depth: footprint == Footprint::Sphere,
            shading,
            color,
            lit,
        }
    };
    let soft = Part::Soft { threshold: 0.5, modulation: None };
    let parts = [Part::All, Part::Solid(0.5), soft, Part::Marked(0.5)];
    let colors = [ColorSpace::Linear, ColorSpace::Encoded];
    let all = || models.into_iter().flat_map(|m| colors.map(|c| (m, c)));
    let plain = all().flat_map(|(model, color)| parts.map(|part| of(model, color, part, false)));
    // Only shaded points of opaque methods have shares of light, and these take all points.
    let lit = all().filter(|(model, _)| *model != ShadingModel::None);
    plain.chain(lit.map(|(model, color)| of(model, color, Part::All, true))).collect()
}

/// The variants of a pass that shades the points it found.
fn point_variants(of: impl Fn(Cut, &Projecting, bool) -> Variant) -> Vec<Variant> {
    let cuts = [Cut { parts: 1, len: 1 << 20 }, Cut { parts: 4, len: 1 << 20 }];
    let all = projectings(Footprint::Point);
    all.iter().flat_map(|how| cuts.map(|cut| of(cut, how, true))).collect()
}

fn compose_variants() -> Vec<Variant> {
    let cuts = [Cut { parts: 1, len: 1 << 20 }, Cut { parts: 4, len: 1 << 20 }];
    let falloffs = [Falloff::Flat, Falloff::Gaussian];
    let shapes = [Footprint::Disc, Footprint::Oriented];
    shapes.iter().flat_map(|s| falloffs.iter().flat_map(move |f| cuts.map(|c| compose::variant(c, *s, *f)))).collect()
}

/// The variants of the kernels for lists of up to the lengths that `wanted` picks.
fn resolve_variants(wanted: fn(u32) -> bool) -> Vec<Variant> {
    let capacities = abuffer::CLASSES.map(|(capacity, _)| capacity).into_iter().filter(|c| wanted(*c));
    capacities.flat_map(|c| compose_variants().into_iter().map(move |v| abuffer::resolve_variant(v, c))).collect()
}

/// The variants of `sorted/blend`, whatever may stop it.
fn blend_variants() -> Vec<Variant> {
    let shapes = [Footprint::Disc, Footprint::Oriented];
    let falloffs = [Falloff::Flat, Falloff::Gaussian];
    let shapes = shapes.iter().flat_map(|s| falloffs.map(|f| compose::shape_variant(*s, f)));
    let stops = shapes.flat_map(|shape| (1..=3).map(move |stop| (shape.clone(), stop)));
    let later = stops.flat_map(|(shape, stop)| [false, true].map(|later| (shape.clone(), stop, later)));
    later
        .flat_map(|(shape, stop, later)| SUBGROUPS.map(|size| sorted::blend_variant(shape.clone(), stop, later, size)))
        .collect()
}

/// The variants of `soft/express`.
fn express_variants() -> Vec<Variant> {
    let stops = (1..=3).flat_map(|stop| [false, true].map(|cut| (stop, cut)));
    let ways = stops.flat_map(|(stop, cut)| {
        (0..8).map(move |i| Way { stop, cut, modulated: i & 1 != 0, counted: i & 2 != 0, later: i & 4 != 0 })
    });
    ways.flat_map(|way| SUBGROUPS.map(|size| express::express_variant(way, size))).collect()
}

const INTERIORS: [Interior; 4] = [
    Interior::Linear,
    Interior::Packed,
    Interior::Shells(Shells::Adaptive, 4.0),
    Interior::Shells(Shells::Fixed(5), 4.0),
];

/// The variants of a pass that visits the pixels of spheres.
fn sphere_variants(of: fn(Variant, Interior, bool) -> Variant) -> Vec<Variant> {
    let shapes = [Footprint::Sphere, Footprint::ExactSphere];
    let pairs = shapes.map(|shape| ["walk_small", "walk_tiles"].map(|walker| (shape, walker)));
    let walkers = || pairs.as_flattened().iter().map(|(s, w)| raster::variant(*s, w).with("SEGMENT", 512));
    let variants =
        INTERIORS.iter().flat_map(|i| [false, true].map(|cut| walkers().map(|w| of(w, *i, cut)).collect::<Vec<_>>()));
    variants.flatten().collect()
}

/// The variants of a pass that blends spheres.
fn interior_variants(of: impl Fn(Kind, Cut) -> Variant) -> Vec<Variant> {
    let cuts = [Cut { parts: 1, len: 1 << 20 }, Cut { parts: 4, len: 1 << 20 }];
    let kinds = INTERIORS.iter().flat_map(|interior| {
        [(false, false), (false, true), (true, false)].map(|(exact, modulated)| Kind {
            interior: *interior,
            exact,
            modulated,
        })
    });
    kinds.flat_map(|kind| cuts.map(|cut| of(kind, cut))).collect()
}

/// The variants of the kernels for events of spheres, of up to the lengths that `wanted` picks.
fn sphere_kernels(wanted: fn(u32) -> bool) -> Vec<Variant> {
    let capacities = soft::classes().map(|(_, (capacity, _))| capacity).filter(|c| wanted(*c));
    capacities.flat_map(|c| interior_variants(|kind, cut| soft::resolve_variant(kind, cut, 1, c))).collect()
}

/// The variants of the draws of `stochastic`.
fn draw_variants() -> Vec<Variant> {
    let shapes = [Footprint::Disc, Footprint::Oriented];
    shapes.iter().flat_map(|s| [Falloff::Flat, Falloff::Gaussian].map(|f| compose::shape_variant(*s, f))).collect()
}

/// The variants of the tile passes of `stochastic`, with the kinds and strata that go with them.
fn stochastic_variants() -> Vec<(Variant, stochastic::Kind, u32)> {
    let shapes = [Footprint::Disc, Footprint::Oriented];
    let shapes = shapes.iter().flat_map(|s| [Falloff::Flat, Falloff::Gaussian].map(|f| compose::shape_variant(*s, f)));
    let later = shapes.flat_map(|shape| [false, true].map(|later| (shape.clone(), later)));
    let sizes = later.flat_map(|(shape, later)| SUBGROUPS.map(|size| (shape.clone(), later, size)));
    let strata = sizes.flat_map(|tile| [2, 4].map(|strata| (tile.clone(), strata)));
    let of = |((shape, later, size), strata), exact, spread| {
        let kind = stochastic::Kind { exact, spread };
        (stochastic::tile_variant(shape, strata, later, size), kind, strata)
    };
    let kinds = [[false, false], [false, true], [true, false], [true, true]];
    strata.flat_map(|tile| kinds.map(|[exact, spread]| of(tile.clone(), exact, spread))).collect()
}

/// Shapes and falloffs with the runs of the approximations, one and the first and second of two.
fn fold_variants(of: impl Fn(Variant, OneRun) -> Vec<Variant>) -> Vec<Variant> {
    let shapes = [Footprint::Disc, Footprint::Oriented];
    let falloffs = [Falloff::Flat, Falloff::Gaussian];
    let shapes = shapes.iter().flat_map(|s| falloffs.map(|f| compose::shape_variant(*s, f)));
    let runs = shapes.flat_map(|shape| [(0, 1), (0, 2), (1, 2)].map(|(number, of)| (shape.clone(), number, of)));
    let sized =
        runs.flat_map(|(shape, number, of)| SUBGROUPS.map(|subgroup| (shape.clone(), OneRun { number, of, subgroup })));
    sized.flat_map(|(shape, run)| of(shape, run)).collect()
}

fn sum_variants() -> Vec<Variant> {
    fold_variants(|shape, run| vec![approximate::sum_variant(shape, run)])
}

/// The variants of `hybrid` over oriented discs, in one round and in several.
fn round_variants() -> Vec<Variant> {
    let rounds = [(1, false, true), (8, false, false), (8, true, false), (3, true, true)];
    let rounds = rounds.map(|(slots, behind, tail)| Round { slots, behind, tail });
    fold_variants(|shape, run| rounds.map(|round| approximate::round_variant(shape.clone(), run, round)).to_vec())
}

/// The variants of a tile pass of three-pass splats: one run, and the first and second of two; before a layer and behind it.
fn splats_variants(of: fn(splats::OneRun, Footprint) -> Variant) -> Vec<Variant> {
    let runs = [(false, false), (false, true), (true, true)];
    let runs = runs.iter().flat_map(|(later, kept)| [false, true].map(|behind| (*later, *kept, behind)));
    let sized = runs
        .flat_map(|(later, kept, behind)| SUBGROUPS.map(|subgroup| splats::OneRun { later, kept, behind, subgroup }));
    sized.flat_map(|run| [Footprint::Disc, Footprint::Oriented].map(|footprint| of(run, footprint))).collect()
}

/// The variants of a pass that goes through slots of ensembles.
fn slots_variants(stage: Stage, of: impl Fn(Variant) -> Vec<Variant>) -> Vec<Variant> {
    let kinds = (0..32).map(|i| spbr::Kind {
        thinned: i & 16 != 0,
        weighted: i & 1 != 0,
        slanted: i & 2 != 0,
        squares: i & 4 != 0,
        planes: i & 8 != 0,
        spread: i & 4 != 0,
    });
    let ways = [(None, false), (None, true), (Some(3), false)];
    kinds.flat_map(|kind| ways.map(|(stripes, counted)| kind.variant(stage, stripes, counted))).flat_map(of).collect()
}

#[test]
fn every_shader_matches_its_pass_in_every_variant() {
    let mut seen = Vec::new();
    let project = FOOTPRINTS.iter().chain(&[Footprint::Sphere]).flat_map(|f| {
        projectings(*f).into_iter().flat_map(|how| [false, true].map(|n| project::project_variant(&how, n)))
    });
    check::<project::Project>(&mut seen, project);
    check::<tiles::TileCount>(&mut seen, [Variant::plain()]);
    check::<tiles::TileStore>(&mut seen, [Variant::plain()]);
    check::<scan::Reduce>(&mut seen, [Variant::plain().with("RUN", 64)]);
    check::<scan::Spread>(&mut seen, scan::variants());
    check::<abuffer::Count>(&mut seen, raster_variants());
    check::<abuffer::Store>(&mut seen, raster_variants());
    check::<abuffer::Measure>(&mut seen, [0, 256].map(abuffer::measure_variant));
    let classes = || [abuffer::class_variant()];
    check::<abuffer::Classify>(&mut seen, classes());
    check::<abuffer::Groups>(&mut seen, classes());
    check::<abuffer::Order>(&mut seen, classes());
    check::<abuffer::ResolveNetwork>(&mut seen, resolve_variants(abuffer::is_network));
    check::<abuffer::ResolveMerge>(&mut seen, resolve_variants(|c| !abuffer::is_network(c)));
    check::<abuffer::Split>(&mut seen, classes());
    check::<abuffer::RunGroups>(&mut seen, [Variant::plain()]);
    check::<abuffer::SortRuns>(&mut seen, [abuffer::sort_runs_variant()]);
    check::<abuffer::Merge>(&mut seen, [Variant::plain()]);
    check::<abuffer::MergeInPlace>(&mut seen, [Variant::plain()]);
    check::<abuffer::BlendRuns>(&mut seen, compose_variants());
    check::<abuffer::Combine>(&mut seen, [Variant::plain()]);
    check::<linked_list::Store>(&mut seen, raster_variants());
    check::<linked_list::Gather>(&mut seen, [false, true].map(linked_list::gather_variant));
    check::<Agree>(&mut seen, [Variant::plain()]);
    check::<splat::Nearest>(&mut seen, relief_variants());
    check::<splat::NearestDepth>(&mut seen, relief_variants());
    check::<splat::NearestId>(&mut seen, relief_variants());
    check::<splat::Resolve>(&mut seen, compose_variants());
    let nearest = || (0..4).map(|i| points::nearest_variant(i & 1 != 0, i & 2 != 0));
    check::<points::Nearest>(&mut seen, nearest());
    check::<points::NearestDepth>(&mut seen, nearest());
    check::<points::NearestId>(&mut seen, nearest());
    check::<points::Resolve>(&mut seen, point_variants(points::resolve_variant));
    for transparent in [false, true] {
        let of = |cut: Cut, how: &Projecting, normals| image_space::resolve_variant(cut, how, normals, transparent);
        check::<image_space::Resolve>(&mut seen, point_variants(of));
    }
    check::<image_space::Measure>(&mut seen, [Variant::plain()]);
    let listed = Filter::ALL.map(Listed::Filter).into_iter().chain([Listed::Resolve, Listed::Deliver]);
    check::<image_space::List>(&mut seen, listed.map(Listed::variant));
    check::<image_space::Fill>(&mut seen, [Variant::plain()]);
    check::<image_space::Occlusion>(&mut seen, [Variant::plain()]);
    check::<image_space::Smooth>(&mut seen, [Variant::plain()]);
    check::<image_space::Antialias>(&mut seen, [Variant::plain()]);
    check::<image_space::Deliver>(&mut seen, [Variant::plain()]);
    check::<peel_layers::Blend>(&mut seen, [false, true].map(peel_layers::blend_variant));
    check::<shadows::Start>(&mut seen, [false, true].map(shadows::start_variant));
    check::<shadows::Nearest>(&mut seen, [shadows::walk_variant()]);
    check::<shadows::Fill>(&mut seen, [shadows::fill_variant()]);
    check::<shadows::Lit>(&mut seen, [false, true].map(shadows::lit_variant));
    check::<shadows::Share>(&mut seen, [Variant::plain()]);
    check::<peel::Count>(&mut seen, raster_variants());
    check::<peel::Nearest>(&mut seen, raster_variants());
    check::<peel::NearestDepth>(&mut seen, raster_variants());
    check::<peel::NearestId>(&mut seen, raster_variants());
    let counted = [0, 1].map(|counted| compose_variants().into_iter().map(move |v| v.with("COUNTED", counted)));
    check::<peel::Blend>(&mut seen, counted.into_iter().flatten());
    check::<peel::Next>(&mut seen, [Variant::plain()]);
    check::<radix::Count>(&mut seen, [Variant::plain()]);
    check::<radix::Scatter>(&mut seen, SUBGROUPS.map(radix::scatter_variant));
    check::<bin::Keys>(&mut seen, [Order::Depth, Order::Index, Order::File].map(bin::keys_variant));
    check::<bin::Gather>(&mut seen, compose_variants());
    check::<bin::Pick>(&mut seen, SUBGROUPS.map(bin::presorted_variant));
    check::<bin::Place>(&mut seen, SUBGROUPS.map(bin::presorted_variant));
    check::<express::Express>(&mut seen, express_variants());
    check::<bin::TileCount>(&mut seen, [bin::tile_variant()]);
    check::<bin::Measure>(&mut seen, [Variant::plain()]);
    check::<bin::TileStore>(&mut seen, SUBGROUPS.map(|size| bin::tile_variant().subgroup(size)));
    check::<sorted::Blend>(&mut seen, blend_variants());
    let stochastic = || stochastic_variants().into_iter();
    check::<stochastic::Visibility>(&mut seen, stochastic().map(|(tiles, ..)| tiles));
    check::<stochastic::Accumulate>(&mut seen, stochastic().map(|(tiles, kind, _)| kind.of(tiles)));
    check::<stochastic::Gather>(
        &mut seen,
        stochastic().map(|(_, kind, strata)| stochastic::gather_variant(kind, strata)),
    );
    check::<stochastic::Resolve>(&mut seen, stochastic().map(|(_, kind, _)| stochastic::resolve_variant(kind)));
    check::<hardware::DrawAlpha>(&mut seen, draw_variants());
    check::<hardware::DrawHeld>(&mut seen, draw_variants());
    check::<hardware::DrawSums>(&mut seen, draw_variants());
    check::<hardware::Fold>(&mut seen, stochastic().map(|(_, kind, _)| hardware::fold_variant(kind)));
    let cuts = [Cut { parts: 1, len: 1 << 20 }, Cut { parts: 4, len: 1 << 20 }];
    let ways = projectings(Footprint::Point);
    let drawn = |v: Variant| cuts.map(|cut| spbr::draw_variant(v.clone(), cut, &ways[0])).to_vec();
    check::<spbr::Draw>(&mut seen, slots_variants(Stage::Draw, drawn));
    check::<spbr::Nearest>(&mut seen, slots_variants(Stage::Nearest, |v| vec![v]));
    check::<spbr::NearestDepth>(&mut seen, slots_variants(Stage::NearestDepth, |v| vec![v]));
    check::<spbr::NearestId>(&mut seen, slots_variants(Stage::NearestId, |v| vec![v]));
    let summed = |v: Variant| ways.iter().step_by(4).map(|how| spbr::sum_variant(v.clone(), how, true)).collect();
    check::<spbr::Sum>(&mut seen, slots_variants(Stage::Sum, summed));
    check::<spbr::Renew>(&mut seen, [Variant::plain()]);
    check::<spbr::Large>(&mut seen, [Variant::plain()]);
    check::<spbr::Resolve>(&mut seen, [false, true].map(spbr::resolve_variant));
    check::<approximate::Weighted>(&mut seen, sum_variants());
    check::<approximate::Average>(&mut seen, sum_variants());
    check::<approximate::Unsorted>(&mut seen, sum_variants());
    check::<approximate::HybridFlat>(&mut seen, sum_variants());
    check::<approximate::HybridOriented>(&mut seen, round_variants());
    check::<splats::Visibility>(&mut seen, splats_variants(splats::OneRun::visibility));
    check::<splats::Attributes>(&mut seen, splats_variants(splats::OneRun::attributes));
    check::<splats::Normalise>(&mut seen, [Variant::plain()]);
    check::<one_layer::Compose>(&mut seen, [Variant::plain()]);
    check::<abuffer::CountTiles>(&mut seen, SUBGROUPS.map(bin::gather_variant));
    check::<abuffer::StoreTiles>(&mut seen, SUBGROUPS.map(bin::gather_variant));
    check::<soft::Count>(&mut seen, sphere_variants(soft::count_variant));
    check::<soft::Store>(&mut seen, sphere_variants(soft::store_variant));
    check::<soft::ResolveNetwork>(&mut seen, sphere_kernels(abuffer::is_network));
    check::<soft::ResolveMerge>(&mut seen, sphere_kernels(|c| !abuffer::is_network(c)));
    check::<soft::SumRuns>(&mut seen, interior_variants(soft::run_variant));
    check::<soft::Carry>(&mut seen, [Variant::plain()]);
    check::<soft::Segments>(&mut seen, interior_variants(soft::segments_variant));
    check::<soft::BlendRuns>(&mut seen, interior_variants(soft::run_variant));
    check::<soft::Compose>(&mut seen, [Variant::plain()]);
    let falloffs = [Falloff::Flat, Falloff::Gaussian];
    let ordered = falloffs.iter().flat_map(|f| (1..4).map(|stop| abuffer::ordered_variant(*f, stop)));
    check::<abuffer::ResolveOrdered>(&mut seen, ordered);

    let forgotten: Vec<String> =
        shader::stems(&SHADERS).into_iter().filter(|s| s != "splat/quad.vert" && !seen.contains(&s.as_str())).collect();
    assert_eq!(forgotten, Vec::<String>::new(), "shader files that no pass uses");
}

#[test]
fn every_compute_shader_has_the_common_workgroup() {
    for stem in shader::stems(&SHADERS) {
        let variant = match stem.as_str() {
            "sorted/blend" => blend_variants().remove(0),
            "stochastic/visibility" | "stochastic/accumulate" => stochastic_variants().remove(0).0,
            "stochastic/gather" => stochastic::gather_variant(stochastic_variants()[0].1, 4),
            "approximate/hybrid_oriented" => round_variants().remove(0),
            other if other.starts_with("approximate/") => sum_variants().remove(0),
            "soft/express" => express_variants().remove(0),
            "bin/pick" | "bin/place" => bin::presorted_variant(SUBGROUPS[0]),
            "splats/visibility" | "splats/attributes" => splats_variants(splats::OneRun::attributes).remove(0),
            "bin/tile_count" | "bin/tile_store" => bin::tile_variant().subgroup(SUBGROUPS[0]),
            "radix/scatter" => radix::scatter_variant(SUBGROUPS[0]),
            "spbr/large" | "spbr/renew" | "spbr/resolve" => Variant::plain(),
            other if other.starts_with("spbr/") => Variant::plain().walker("spbr_slots"),
            "abuffer/count_tiles" | "abuffer/store_tiles" => bin::gather_variant(SUBGROUPS[0]),
            other if other.starts_with("soft/resolve") => {
                let kind = Kind { interior: Interior::Linear, exact: false, modulated: false };
                soft::resolve_variant(kind, Cut { parts: 1, len: 1 }, 1, 128)
            }
            _ => abuffer::class_variant().constant("CAPACITY", 64).constant("BLOCK", 4).network(4).walker("walk_small"),
        };
        let (stage, workgroup) = shader::entry_point(&SHADERS, &stem, &variant).expect("a valid shader");
        if stem == "splat/quad.vert" {
            assert_eq!(format!("{stage:?}"), "Vertex");
        } else if stem.starts_with("stochastic/draw_") {
            assert_eq!(format!("{stage:?}"), "Fragment");
        } else {
            let single = ["abuffer/groups", "abuffer/run_groups", "peel/next"].contains(&stem.as_str());
            let by_subgroup = [
                "radix/scatter",
                "sorted/blend",
                "soft/express",
                "bin/pick",
                "bin/place",
                "bin/tile_store",
                "abuffer/count_tiles",
                "abuffer/store_tiles",
                "stochastic/visibility",
                "stochastic/accumulate",
                "splats/visibility",
                "splats/attributes",
            ]
            .contains(&stem.as_str());
            let wanted = if single { 1 } else { WORKGROUP };
            let by_subgroup = by_subgroup || stem.starts_with("approximate/");
            let wanted = if by_subgroup { SUBGROUPS[0] } else { wanted };
            assert_eq!(workgroup, [wanted, 1, 1], "{stem}");
        }
    }
}

gpu_struct! {
    /// A member renamed.
    pub struct Renamed {
        amount: u32,
    }
}

gpu_struct! {
    /// A member too many.
    pub struct Longer {
        count: u32,
        more: u32,
    }
}

pass! {
    /// As declared in earnest.
    Right(scan::ScanPush) = "scan/reduce" { values: Read<u32>, sums: ReadWrite<u32>, overflow: ReadWrite<u32> }
}
pass! {
    /// Another name.
    WrongName(scan::ScanPush) = "scan/reduce" { value: Read<u32>, sums: ReadWrite<u32>, overflow: ReadWrite<u32> }
}
pass! {
    /// Another access.
    WrongAccess(scan::ScanPush) = "scan/reduce" { values: ReadWrite<u32>, sums: ReadWrite<u32>, overflow: ReadWrite<u32> }
}
pass! {
    /// Another element.
    WrongElement(scan::ScanPush) = "scan/reduce" { values: Read<f32>, sums: ReadWrite<u32>, overflow: ReadWrite<u32> }
}
pass! {
    /// A binding too few.
    TooFew(scan::ScanPush) = "scan/reduce" { values: Read<u32>, sums: ReadWrite<u32> }
}
pass! {
    /// A binding too many.
    TooMany(scan::ScanPush) = "scan/reduce" { values: Read<u32>, sums: ReadWrite<u32>, overflow: ReadWrite<u32>, rest: Read<u32> }
}
pass! {
    /// Push constants with another name.
    WrongPush(Renamed) = "scan/reduce" { values: Read<u32>, sums: ReadWrite<u32>, overflow: ReadWrite<u32> }
}
pass! {
    /// Push constants of another size.
    LongPush(Longer) = "scan/reduce" { values: Read<u32>, sums: ReadWrite<u32>, overflow: ReadWrite<u32> }
}
pass! {
    /// No push constants.
    NoPush = "scan/reduce" { values: Read<u32>, sums: ReadWrite<u32>, overflow: ReadWrite<u32> }
}

#[test]
fn a_declaration_that_differs_from_its_shader_is_refused() {
    fn result<P: Pass>() -> Result<(), String> {
        shader::check::<P>(&Variant::plain()).map_err(|e| e.to_string())
    }
    result::<Right>().expect("the declaration in earnest");
    let refusals = [
        (result::<WrongName>(), "\"values\" in WGSL and \"value\""),
        (result::<WrongAccess>(), "Read in WGSL, ReadWrite"),
        (result::<WrongElement>(), "Plain(\"f32\")"),
        (result::<TooFew>(), "no binding 2"),
        (result::<TooMany>(), "\"rest\" is missing"),
        (result::<WrongPush>(), "amount"),
        (result::<LongPush>(), "of 8 bytes"),
        (result::<NoPush>(), "no push constants"),
    ];
    for (result, part) in refusals {
        let message = result.expect_err(part);
        assert!(message.contains(part), "{message:?} should say {part:?}");
    }
}

/// What every driver computes in its own way, or in an order of its own, is written out in shared/elementary.wgsl. A sum of two
/// products has no order, so that `dot` of two components may stay.
#[test]
fn no_shader_leaves_to_the_driver_what_drivers_do_differently() {
    const OWN: &[&str] = &[
        "exp",
        "exp2",
        "log",
        "log2",
        "pow",
        "sin",
        "cos",
        "tan",
        "asin",
        "acos",
        "atan",
        "atan2",
        "sinh",
        "cosh",
        "tanh",
        "inverseSqrt",
        "length",
        "distance",
        "normalize",
        "reflect",
        "refract",
        "mix",
        "smoothstep",
        "fma",
        "pack4x8unorm",
        "pack4x8snorm",
        "pack2x16unorm",
        "pack2x16float",
        "round",
    ];
    /// Calls of any of these in a line, without its comment.
    fn calls(line: &str) -> Vec<&str> {
        let code = line.split("//").next().unwrap_or_default();
        let words = code.split('(').filter_map(|part| {
            part.rsplit(|c: char| !c.is_ascii_alphanumeric() && c != '_').next().filter(|word| OWN.contains(word))
        });
        // Behind the last parenthesis comes no call.
        words.take(code.matches('(').count()).collect()
    }
    assert_eq!(calls("let a = exp(-x) + my_log(y) / length3(v); // pow(x)"), ["exp"]);
    assert_eq!(calls("fn f(length: f32) { return length; }"), Vec::<&str>::new());

    let mut folders = vec![std::path::Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../engine")).join("shaders")];
    let mut files = 0;
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).expect("a folder of shaders") {
            let path = entry.expect("an entry").path();
            if path.is_dir() {
                folders.push(path);
                continue;
            }
            files += 1;
            let text = std::fs::read_to_string(&path).expect("a shader");
            for (line, number) in text.lines().zip(1..) {
                assert_eq!(calls(line), Vec::<&str>::new(), "{}, line {number}: {line}", path.display());
            }
        }
    }
    assert!(files > 100, "{files}");
}

#[test]
fn an_unknown_override_is_refused() {
    let error = shader::check::<Right>(&Variant::plain().with("NO_SUCH", 1)).expect_err("no such override");
    assert!(error.to_string().contains("NO_SUCH"));
}
