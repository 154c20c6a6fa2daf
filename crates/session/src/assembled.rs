//! Assembles the points of a scene on the host from its clouds, with notes about them.

use std::path::Path;
use std::sync::{Arc, OnceLock};

use pellucid_core::cloud::shadow_texture::ShadowTexture;
use pellucid_core::cloud::{Cloud, UpAxis};
use pellucid_core::color::ColorSpace;
use pellucid_core::points::{Changes, Points};
use pellucid_core::progress::Progress;
use pellucid_engine::Result;
use pellucid_scene::legend::Legend;
use pellucid_scene::prepare::Arranged;
use pellucid_scene::stored::Stored;
use pellucid_scene::tracked::{self, DerivedColumns, Tracked};
use pellucid_scene::{
    self as scene, Background, CloudSettings, Family, Method, Recipe, Scene, ScreenSplats, ShadingModel,
};

use crate::messages::Messages;
use crate::sources::{Clouds, Sources};

/// Form in which points are wanted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Wanted {
    /// Seed of the shuffle into ensembles.
    pub seed: u64,
    /// `true` if the meaning of colors is wanted.
    pub legend: bool,
    /// `true` for radii and canonical order even if the scene's method does without. Stored points are as the method
    /// wants them.
    pub radii: bool,
    /// `true` if points in memory are to follow changed keys; clouds and derived columns are then retained.
    pub is_edited: bool,
}

/// The points of a scene, and what is known of them.
pub struct Assembled {
    /// The scene with what its clouds decide.
    pub scene: Scene,
    /// Meaning of the colors, if it was wanted.
    pub legend: Option<Legend>,
    /// Coloring of clouds and the reason for it, a phrase for each way.
    pub colorings: Vec<String>,
    /// Vertical of the clouds.
    pub up: UpAxis,
    /// Shadows that were stored with the scene's cloud, in the order of the file.
    pub shadow_texture: Option<ShadowTexture>,
    /// `true` if some points have classes other than 0 and 1.
    pub is_classified: bool,
    origin: Origin,
    /// Color space and shading that clouds decided.
    settled: Settled,
    recipe: Recipe,
    has_gaussians: bool,
    /// `true` for clouds whose points have a size of their own.
    sized: Vec<bool>,
    wanted: Wanted,
}

/// Where the points come from.
enum Origin {
    /// Points of clouds that are gone.
    Once(Arranged),
    /// Points that follow an edited scene, of clouds in memory.
    Tracked(Box<Tracked>),
    /// Points of clouds that stay in their files.
    Stored(Box<Stored>, Arranged),
}

/// Keys that the clouds of a scene decided.
#[derive(Debug, Clone)]
struct Settled {
    /// The space in which colors are blended because all clouds are of Gaussians.
    blend_space: Option<ColorSpace>,
    /// `true` if points have no normals to shade by.
    is_unlit: bool,
    /// `true` if the points are dark, once a scene leaves the background to them.
    is_dark: OnceLock<bool>,
}

impl Assembled {
    /// Makes points of a scene's clouds. Unless they are edited, clouds in memory are consumed.
    ///
    /// # Errors
    /// Returns an error if no point is left, if a cloud lacks what the scene needs, or if a temporary file can't be
    /// written.
    pub fn new(
        sources: &mut Sources,
        scene: &Scene,
        wanted: Wanted,
        messages: &dyn Messages,
        progress: &Progress,
    ) -> Result<Self> {
        let is_classified = sources.are_classified();
        let units = scene::differing_units(scene, &sources.systems());
        let Sources { clouds, derived, memory, .. } = sources;
        let mut made = match clouds {
            Clouds::Held(clouds) => {
                Self::of_clouds(scene, (clouds, derived), wanted, is_classified, messages, progress)?
            }
            Clouds::Stored(stores) => {
                let stored = Stored::new(scene, stores, *memory, progress)?;
                Self::of_stores(scene, stored, wanted, messages, progress)?
            }
        };
        units.iter().for_each(|warning| messages.warn(warning));
        made.colorings.iter().for_each(|how| messages.detail(how));
        let is_dark = made.scene.image.background == Background::Auto && made.settled.is_dark(made.points());
        if let Some(name) = made.scene.settle_background(|| is_dark) {
            let reason = if is_dark { "the points are dark" } else { "the points are not dark" };
            messages.detail(&format_args!("the background is {name}: {reason}"));
        }
        scene::note_of_layers(&made.scene, made.points()).iter().for_each(|note| messages.note(note));
        Ok(made)
    }

    /// Finds facts about clouds in memory, reports what is odd, settles what they decide about the scene, and makes
    /// points of them.
    fn of_clouds(
        scene: &Scene,
        (clouds, derived): (&mut Vec<Arc<Cloud>>, &mut [DerivedColumns]),
        wanted: Wanted,
        is_classified: bool,
        messages: &dyn Messages,
        progress: &Progress,
    ) -> Result<Self> {
        let (mut scene, mut with_radii) = (scene.clone(), for_points(scene, wanted));
        scene::notes(&with_radii, clouds, with_radii.method.needs_radii()).iter().for_each(|note| messages.note(note));
        let (shadow_texture, note) = scene::shadow_texture(&with_radii, clouds, wanted.seed);
        note.iter().for_each(|note| messages.note(note));
        let up = scene::up_axis(clouds);
        let has_gaussians = clouds.iter().any(|cloud| cloud.gaussians.is_some());
        let recipe = Recipe::of(&scene, wanted.seed, up, has_gaussians);
        let sized = clouds.iter().map(|cloud| is_sized(cloud)).collect();
        let mut colorings = colorings(&with_radii, &scene::colorings(&with_radii, clouds));
        let settled = Settled { blend_space: with_radii.settle(clouds), is_unlit: false, is_dark: OnceLock::new() };
        scene.image.color = with_radii.image.color;
        colorings.extend(settled.blend_space.map(blended));
        let mut legend = None;
        let origin = if wanted.is_edited {
            let tracked = Tracked::new(&with_radii, clouds, derived, wanted.seed, progress)?;
            if wanted.legend {
                legend = Some(tracked::legend(&with_radii, clouds, derived)?);
            }
            Origin::Tracked(Box::new(tracked))
        } else {
            let clouds = std::mem::take(clouds).into_iter().map(Arc::unwrap_or_clone).collect();
            Origin::Once(if wanted.legend {
                let (arranged, found) = scene::arrange_with_legend(&with_radii, clouds, wanted.seed, progress)?;
                legend = Some(found);
                arranged
            } else {
                scene::arrange(&with_radii, clouds, wanted.seed, progress)?
            })
        };
        Ok(Self {
            scene,
            legend,
            colorings,
            up,
            shadow_texture,
            is_classified,
            origin,
            settled,
            recipe,
            has_gaussians,
            sized,
            wanted,
        })
    }

    /// Points stay in their files; for ensembles they are shuffled into a temporary file.
    fn of_stores(
        asked: &Scene,
        stored: Stored,
        wanted: Wanted,
        messages: &dyn Messages,
        progress: &Progress,
    ) -> Result<Self> {
        stored.notes.iter().for_each(|note| messages.note(note));
        let arranged = if stored.scene().method.is_dealt() {
            let folder = std::env::temp_dir();
            messages.detail(&format_args!("points are dealt to ensembles in a temporary file in {}", folder.display()));
            stored.dealt(wanted.seed, &folder, progress)?
        } else {
            stored.arranged()
        };
        let mut colorings = colorings(stored.scene(), &stored.colorings());
        colorings.extend(stored.blend_space.map(blended));
        let (scene, up, has_gaussians) = (stored.scene().clone(), stored.up(), stored.has_gaussians);
        let settled = Settled {
            blend_space: stored.blend_space,
            is_unlit: scene.shading.model == ShadingModel::None && asked.shading.model == ShadingModel::Auto,
            is_dark: OnceLock::new(),
        };
        Ok(Self {
            legend: wanted.legend.then(|| stored.legend.clone()),
            colorings,
            up,
            shadow_texture: None,
            is_classified: stored.is_classified(),
            settled,
            recipe: Recipe::of(asked, wanted.seed, up, has_gaussians),
            has_gaussians,
            sized: stored.likes().map(is_sized).collect(),
            wanted,
            scene,
            origin: Origin::Stored(Box::new(stored), arranged),
        })
    }

    /// Returns all points in the order that the method wants.
    pub fn arranged(&self) -> &Arranged {
        match &self.origin {
            Origin::Once(arranged) | Origin::Stored(_, arranged) => arranged,
            Origin::Tracked(tracked) => tracked.arranged(),
        }
    }

    /// Replaces the points by others that stand for the same scene, such as those of other processes.
    pub fn replace(&mut self, arranged: Arranged) {
        match &mut self.origin {
            Origin::Once(old) | Origin::Stored(_, old) => *old = arranged,
            Origin::Tracked(_) => self.origin = Origin::Once(arranged),
        }
    }

    /// Returns all points, or a sample of stored ones.
    pub fn points(&self) -> &Points {
        self.arranged().points()
    }

    /// Returns the scene in its files, if its clouds stay there.
    pub fn stored(&self) -> Option<&Stored> {
        match &self.origin {
            Origin::Stored(stored, _) => Some(stored),
            Origin::Once(_) | Origin::Tracked(_) => None,
        }
    }

    /// Returns the names of the clouds in [`Arranged::surfaces`], which omits clouds without points.
    pub fn cloud_names(&self) -> Vec<String> {
        let (clouds, count) = (&self.scene.clouds, self.arranged().surfaces().len());
        if clouds.len() == count {
            clouds.iter().map(|cloud| cloud.path.display().to_string()).collect()
        } else {
            (1..=count).map(|number| format!("cloud {number} of those with points")).collect()
        }
    }

    /// Returns the meaning of the colors of a scene that these points are those of.
    ///
    /// # Errors
    /// Returns an error if a cloud lacks what its colors are to show.
    pub fn legend_of(&self, scene: &Scene, sources: &Sources) -> Result<Legend> {
        match (&self.origin, &sources.clouds) {
            (Origin::Tracked(_), Clouds::Held(clouds)) => Ok(tracked::legend(scene, clouds, &sources.derived)?),
            (Origin::Stored(stored, _), _) => Ok(stored.legend.clone()),
            _ => Ok(self.legend.clone().unwrap_or_default()),
        }
    }

    /// Gives another scene of the same clouds what these decide: the color space of Gaussians, no shading without
    /// normals, and the background that is left to the points.
    pub fn settle(&self, scene: &mut Scene) {
        if self.settled.blend_space.is_some() && scene.image.color.is_none() {
            scene.image.color = self.scene.image.color;
        }
        if self.settled.is_unlit && scene.shading.model == ShadingModel::Auto {
            scene.shading.model = ShadingModel::None;
        }
        scene.settle_background(|| self.settled.is_dark(self.points()));
    }

    /// Turns the points into those of another scene of the same clouds. Returns the columns that changed, or `None`,
    /// with everything unchanged, if they must be made again.
    ///
    /// # Errors
    /// Returns an error if a cloud lacks the columns of its field or colors; nothing changes.
    pub(crate) fn follow(
        &mut self,
        sources: &mut Sources,
        scene: &Scene,
        seed: u64,
        progress: &Progress,
    ) -> Result<Option<Changes>> {
        let recipe = Recipe::of(scene, seed, self.up, self.has_gaussians);
        if recipe == self.recipe {
            self.adopt(scene);
            return Ok(Some(Changes::default()));
        }
        let is_other_shuffle = scene.method.is_dealt() && seed != self.wanted.seed;
        let (Origin::Tracked(tracked), Clouds::Held(clouds)) = (&mut self.origin, &sources.clouds) else {
            return Ok(None);
        };
        if is_other_shuffle {
            return Ok(None);
        }
        let with_radii = for_points(scene, self.wanted);
        let Some(changes) = tracked.follow(&with_radii, clouds, &mut sources.derived, progress)? else {
            return Ok(None);
        };
        if self.wanted.legend {
            self.legend = Some(tracked::legend(&with_radii, clouds, &sources.derived)?);
        }
        self.recipe = recipe;
        self.settled.is_dark = OnceLock::new();
        self.adopt(scene);
        self.colorings = colorings(&self.scene, &scene::colorings(&self.scene, clouds));
        self.colorings.extend(self.settled.blend_space.map(blended));
        Ok(Some(changes))
    }

    fn adopt(&mut self, scene: &Scene) {
        let mut settled = scene.clone();
        self.settle(&mut settled);
        self.scene = settled;
    }

    /// Returns the shadows stored with a scene's cloud, if they are those of the scene.
    pub(crate) fn stored_shadows(&self, sources: &Sources, scene: &Scene, seed: u64) -> Option<ShadowTexture> {
        match (&self.origin, &sources.clouds) {
            (Origin::Tracked(_), Clouds::Held(clouds)) => scene::shadow_texture(scene, clouds, seed).0,
            _ => None,
        }
    }

    /// Returns `true` if all points are discs whose radii were estimated from neighbors, and nothing is said of them.
    pub fn has_estimated_radii(&self) -> bool {
        let is_estimated = |(cloud, sized): (&CloudSettings, &bool)| {
            !sized && cloud.radius.is_none() && cloud.radius_factor == CloudSettings::default().radius_factor
        };
        let method = &self.scene.method;
        method.needs_radii() && method.is_made_of_discs() && self.scene.clouds.iter().zip(&self.sized).all(is_estimated)
    }

    /// Returns the form in which the points were wanted.
    pub fn wanted(&self) -> Wanted {
        self.wanted
    }
}

impl Settled {
    /// Returns `true` if these points are dark, which is found once.
    fn is_dark(&self, points: &Points) -> bool {
        *self.is_dark.get_or_init(|| scene::are_dark(points))
    }
}

/// Returns `true` if the points of a cloud have a size of their own.
fn is_sized(cloud: &Cloud) -> bool {
    cloud.own_radii().is_some() || cloud.gaussians.is_some()
}

/// Returns the scene whose points are made: with a method that has radii, if they are wanted whatever the method.
fn for_points(scene: &Scene, wanted: Wanted) -> Scene {
    let mut scene = scene.clone();
    let is_opaque = |method: &Method| method.family() == Family::Opaque || matches!(method, Method::ImageSpace(_));
    if wanted.radii && !scene.method.needs_radii() && scene.method.fixed().is_some_and(is_opaque) {
        // Like these, circles want the points in canonical order, and nothing else of them.
        scene.method = Method::Circles(ScreenSplats::default()).into();
    }
    scene
}

/// Says which colors a scene of Gaussians alone blends.
fn blended(space: ColorSpace) -> String {
    match space {
        ColorSpace::Encoded => "colors are blended as encoded values, because every cloud is of Gaussians",
        ColorSpace::Linear => "colors are blended in linear light, because those of the Gaussians are linear",
    }
    .to_owned()
}

/// Returns how clouds are colored and why, a phrase for each way.
fn colorings(scene: &Scene, each: &[String]) -> Vec<String> {
    let mut ways: Vec<(&str, Vec<&Path>)> = Vec::new();
    for (settings, way) in scene.clouds.iter().zip(each) {
        match ways.iter_mut().find(|(known, _)| known == way) {
            Some((_, paths)) => paths.push(&settings.path),
            None => ways.push((way, vec![&settings.path])),
        }
    }
    let phrase = |(way, paths): &(&str, Vec<&Path>)| match paths[..] {
        [path] => format!("{} is colored by {way}", path.display()),
        _ => format!("{} clouds are colored by {way}", paths.len()),
    };
    ways.iter().map(phrase).collect()
}
