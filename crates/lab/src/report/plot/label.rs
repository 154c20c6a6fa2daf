//! Places the labels of points near their markers without overlap.

/// Height of a label in pixels.
const HEIGHT: i32 = 14;
/// Pixels that a character takes in a wide font.
const CHARACTER: i32 = 6;
/// Half of a marker's side in pixels, with a little air.
const MARKER: i32 = 6;
/// Half of a ring's side in pixels, with a little air.
const RING: i32 = 9;

/// Left, top, right and bottom in pixels.
pub(super) type Rectangle = [i32; 4];

/// A place in pixels.
type PixelPoint = (i32, i32);

/// Labels further from their marker than this are tied to it by a line, and so are those as near to another one.
const NEAR: i32 = 14;

/// The position of a label.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct LabelPosition {
    /// The middle of the text's left end.
    pub text: PixelPoint,
    /// The area the text covers.
    pub rectangle: Rectangle,
    /// The end of a line from the marker; `None` where the label is close enough to need no line.
    pub tie: Option<PixelPoint>,
}

/// A panel and what is drawn in it already.
#[derive(Debug, Clone, Default)]
pub(super) struct Space {
    frame: Rectangle,
    taken: Vec<Rectangle>,
    markers: Vec<PixelPoint>,
    lines: Vec<[PixelPoint; 2]>,
}

impl Space {
    /// Labels stay within the frame.
    pub(super) fn new(frame: Rectangle) -> Self {
        Self { frame, ..Self::default() }
    }

    /// Keeps labels off this rectangle.
    pub(super) fn take(&mut self, rectangle: Rectangle) {
        self.taken.push(rectangle);
    }

    /// Keeps labels off this marker.
    pub(super) fn take_marker(&mut self, (x, y): PixelPoint) {
        self.markers.push((x, y));
        self.take([x - MARKER, y - MARKER, x + MARKER, y + MARKER]);
    }

    /// Keeps labels off this ring around a marker.
    pub(super) fn take_ring(&mut self, (x, y): PixelPoint) {
        self.take([x - RING, y - RING, x + RING, y + RING]);
    }

    /// Makes labels prefer places off this line.
    pub(super) fn avoid(&mut self, line: [PixelPoint; 2]) {
        self.lines.push(line);
    }

    /// Finds a place for the label of a marker and reserves it. `None` if no place is free.
    pub(super) fn place(&mut self, (x, y): PixelPoint, text: &str) -> Option<LabelPosition> {
        let width = CHARACTER * text.chars().count() as i32;
        let candidates = [8, 12, 18, 26, 36].into_iter().flat_map(|away| {
            let side = away * 3 / 4;
            let (left, middle, right) = (x - width, x - width / 2, x);
            [
                (right + away, y),
                (right + side, y - side - HEIGHT / 3),
                (middle, y - away - HEIGHT / 2),
                (right + side, y + side + HEIGHT / 3),
                (middle, y + away + HEIGHT / 2),
                (left - away, y),
                (left - side, y - side - HEIGHT / 3),
                (left - side, y + side + HEIGHT / 3),
            ]
        });
        let free = candidates.enumerate().filter_map(|(order, place)| {
            let (left, top) = (place.0, place.1 - HEIGHT / 2);
            let rectangle = [left, top, left + width, top + HEIGHT];
            // A line behind a label costs as much as being twelve places worse.
            let crossed = self.lines.iter().filter(|line| crosses(rectangle, line)).count();
            // Another marker at the same distance would be ambiguous.
            let own = distance(rectangle, (x, y));
            let is_rival = |marker: &&PixelPoint| **marker != (x, y) && distance(rectangle, **marker) <= own + NEAR / 4;
            let rivals = self.markers.iter().filter(is_rival).count();
            self.is_free(rectangle).then_some((order + 12 * (crossed + rivals), place, rectangle, rivals))
        });
        let (_, place, rectangle, rivals) = free.min_by_key(|(cost, ..)| *cost)?;
        self.take(rectangle);
        let is_tied = rivals > 0 || distance(rectangle, (x, y)) > NEAR;
        Some(LabelPosition { text: place, rectangle, tie: is_tied.then_some(nearest(rectangle, (x, y))) })
    }

    fn is_free(&self, [left, top, right, bottom]: Rectangle) -> bool {
        let frame = self.frame;
        let is_within = left >= frame[0] && top >= frame[1] && right <= frame[2] && bottom <= frame[3];
        let overlaps = |other: &Rectangle| left < other[2] && other[0] < right && top < other[3] && other[1] < bottom;
        is_within && !self.taken.iter().any(overlaps)
    }
}

/// The place of a rectangle that is nearest to another one.
fn nearest([left, top, right, bottom]: Rectangle, (x, y): PixelPoint) -> PixelPoint {
    (x.clamp(left, right), y.clamp(top, bottom))
}

/// The distance of a place from a rectangle, along the axis where it is larger.
fn distance(rectangle: Rectangle, (x, y): PixelPoint) -> i32 {
    let (nx, ny) = nearest(rectangle, (x, y));
    (nx - x).abs().max((ny - y).abs())
}

/// True if a line enters a rectangle, to 3 pixels.
fn crosses([left, top, right, bottom]: Rectangle, [from, to]: &[PixelPoint; 2]) -> bool {
    let (dx, dy) = (i64::from(to.0) - i64::from(from.0), i64::from(to.1) - i64::from(from.1));
    let steps = dx.abs().max(dy.abs()) / 3 + 1;
    (0..=steps).any(|step| {
        let x = i64::from(from.0) + dx * step / steps;
        let y = i64::from(from.1) + dy * step / steps;
        (i64::from(left)..=i64::from(right)).contains(&x) && (i64::from(top)..=i64::from(bottom)).contains(&y)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_lie_over_nothing() {
        let mut space = Space::new([0, 0, 200, 100]);
        for marker in [(100, 50), (110, 50)] {
            space.take_marker(marker);
        }
        let taken = space.taken.len();
        let places: Vec<_> =
            ["64", "128", "256", "512"].iter().filter_map(|text| space.place((100, 50), text)).collect();
        assert_eq!(places.len(), 4);
        for (index, a) in space.taken.iter().enumerate().skip(taken) {
            assert!(a[0] >= 0 && a[1] >= 0 && a[2] <= 200 && a[3] <= 100, "{a:?}");
            for b in &space.taken[..index] {
                assert!(a[0] >= b[2] || b[0] >= a[2] || a[1] >= b[3] || b[1] >= a[3], "{a:?} over {b:?}");
            }
        }
    }

    #[test]
    fn a_label_is_nearest_to_its_own_marker_or_tied_to_it() {
        let mut space = Space::new([0, 0, 200, 100]);
        let markers = [(60, 90), (100, 90), (118, 90)];
        markers.into_iter().for_each(|marker| space.take_marker(marker));
        for (marker, text) in markers.into_iter().zip(["a long label", "another one", "the third"]) {
            let placed = space.place(marker, text).unwrap();
            let own = distance(placed.rectangle, marker);
            let others = markers.into_iter().filter(|other| *other != marker);
            let is_nearest = others.map(|other| distance(placed.rectangle, other)).all(|other| other > own);
            assert!(is_nearest || placed.tie.is_some(), "{text}: {placed:?}");
        }
    }

    #[test]
    fn the_right_side_is_taken_unless_a_line_or_the_frame_is_there() {
        let space = Space::new([0, 0, 200, 100]);
        let right = space.clone().place((100, 50), "8").unwrap();
        assert_eq!((right.text, right.rectangle, right.tie), ((108, 50), [108, 43, 114, 57], None));
        let mut crossed = space.clone();
        crossed.avoid([(100, 50), (200, 50)]);
        assert_ne!(crossed.place((100, 50), "8").unwrap().text.1, 50);
        assert!(space.clone().place((195, 50), "8").unwrap().text.0 < 195);
        let mut full = space;
        full.take([80, 30, 120, 70]);
        let far = full.place((100, 50), "8").unwrap();
        assert_eq!((far.text, far.tie), ((126, 50), Some((126, 50))));
        assert_eq!(Space::new([0, 0, 20, 20]).place((10, 10), "a long label"), None);
    }
}
