//! Exchange of the points that may show in another rank's region.

use std::convert::Infallible;

use pellucid_core::points::{Points, Unreadable};
use pellucid_engine::passes::bands::Window;
use pellucid_engine::passes::portion::Portion;
use pellucid_engine::passes::project::Beam;

use super::super::cut::is_empty;
use super::super::ranks::Ranks;

/// The partners of a rank, one after the other, so that all ranks meet all others in pairs at the same time: the
/// players of a round-robin tournament.
pub fn partners(own: usize, count: usize) -> impl Iterator<Item = usize> {
    // Of an odd number one has nobody at each step.
    let players = count + count % 2;
    let turning = players.saturating_sub(1).max(1);
    let partner = move |step: usize| {
        if own == turning {
            // Who would meet himself.
            return step * (players / 2) % turning;
        }
        let partner = (step + turning - own) % turning;
        if partner == own { turning } else { partner }
    };
    (0..players.saturating_sub(1)).map(partner).filter(move |partner| *partner < count)
}

/// The points of all ranks, in the order of these, that may show in this rank's one of the regions; the others get
/// theirs.
///
/// # Errors
/// A rank sent something else than points.
pub fn exchanged(
    ranks: &Ranks,
    windows: &[Window],
    portion: &Portion,
    beam: impl Fn(Window) -> Beam,
    piece: usize,
) -> Result<Vec<Points>, Unreadable> {
    let own = ranks.own();
    let mut parts = vec![Vec::new(); ranks.count()];
    let of_window = |window: Window| Some(window).filter(|window| !is_empty(*window)).map(&beam);
    if let Some(beam) = of_window(windows[own]) {
        each(portion, &beam, |points| parts[own].push(points));
    }
    for partner in partners(own, ranks.count()) {
        let give = || send(ranks, partner, portion, of_window(windows[partner]), piece);
        if own < partner {
            give();
            parts[partner] = receive(ranks, partner)?;
        } else {
            parts[partner] = receive(ranks, partner)?;
            give();
        }
    }
    Ok(parts.concat())
}

fn each(portion: &Portion, beam: &Beam, mut see: impl FnMut(Points)) {
    let seen: Result<(), Infallible> = portion.within(beam, |points| {
        see(points);
        Ok(())
    });
    let Ok(()) = seen;
}

/// Sends points in pieces, and an empty one as the end.
fn send(ranks: &Ranks, to: usize, portion: &Portion, beam: Option<Beam>, piece: usize) {
    if let Some(beam) = beam {
        in_pieces(portion, &beam, piece, |bytes| ranks.send(to, bytes));
    }
    ranks.send(to, &[]);
}

/// Points that may show there as bytes, about so many at a time.
fn in_pieces(portion: &Portion, beam: &Beam, piece: usize, mut give: impl FnMut(&[u8])) {
    let mut bytes = Vec::new();
    each(portion, beam, |points| {
        points.pack(&mut bytes);
        if bytes.len() >= piece {
            give(&bytes);
            bytes.clear();
        }
    });
    if !bytes.is_empty() {
        give(&bytes);
    }
}

fn receive(ranks: &Ranks, from: usize) -> Result<Vec<Points>, Unreadable> {
    let mut parts = Vec::new();
    loop {
        let bytes = ranks.received(from);
        if bytes.is_empty() {
            return Ok(parts);
        }
        take_piece(&bytes, &mut parts)?;
    }
}

/// Adds the points of a piece to those of others.
fn take_piece(mut bytes: &[u8], parts: &mut Vec<Points>) -> Result<(), Unreadable> {
    while !bytes.is_empty() {
        parts.push(Points::unpack(&mut bytes)?);
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use glam::{DVec3, Vec3};
    use pellucid_core::camera::{Camera, Projection};
    use pellucid_engine::passes::portion::Runs;
    use pellucid_engine::passes::project::PointExtent;

    use super::*;

    #[test]
    fn every_rank_meets_every_other_once_and_both_at_the_same_step() {
        for count in 1..=17 {
            // Each has its next meeting with somebody who has his with it, until nobody has any.
            let mut left: Vec<Vec<usize>> = (0..count).map(|own| partners(own, count).collect()).collect();
            for (own, all) in left.iter().enumerate() {
                let mut sorted = all.clone();
                sorted.sort_unstable();
                assert_eq!(sorted, (0..count).filter(|other| *other != own).collect::<Vec<_>>(), "{own} of {count}");
            }
            while left.iter().any(|all| !all.is_empty()) {
                let next: Vec<Option<usize>> = left.iter().map(|all| all.first().copied()).collect();
                let met: Vec<usize> =
                    (0..count).filter(|own| next[*own].is_some_and(|p| next[p] == Some(*own))).collect();
                assert!(!met.is_empty(), "{count}: nobody goes on {next:?}");
                for own in met {
                    left[own].remove(0);
                }
            }
        }
    }

    #[test]
    fn points_come_in_pieces_however_small() {
        let positions: Vec<DVec3> = (0..20_000).map(|at| DVec3::new(f64::from(at) * 1e-4, 0.0, 0.0)).collect();
        let count = positions.len();
        let all = Points {
            positions,
            colors: vec![Vec3::ONE; count],
            opacities: vec![0.5; count],
            radii: vec![0.01; count],
            ..Points::default()
        };
        let mut portion = Portion::default();
        portion.add(Runs::of(&all, &Runs::starts(&all), None));
        let projection = Projection::Orthographic { height: 4.0 };
        let camera = Camera::look_at(DVec3::Z, DVec3::ZERO, DVec3::Y, projection, 0.1, 10.0).expect("a camera");
        let beam = Beam::new(&camera, [100, 100], [50, 0, 75, 100], PointExtent::discs(1.0));
        for piece in [1, 100_000, 1 << 30] {
            let (mut parts, mut pieces) = (Vec::new(), 0);
            in_pieces(&portion, &beam, piece, |bytes| {
                pieces += 1;
                take_piece(bytes, &mut parts).expect("points");
            });
            let found: usize = parts.iter().map(Points::len).sum();
            assert!((10_000..11_000).contains(&found), "{found}");
            assert_eq!(pieces, [3, 3, 1][usize::from(piece > 1) + usize::from(piece > 100_000)], "{piece}");
        }
        assert!(take_piece(&[1, 2, 3], &mut Vec::new()).is_err());
    }
}
