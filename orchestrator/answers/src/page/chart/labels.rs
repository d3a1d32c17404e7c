//! Where names of points stand: beside their points, within the frame, as little as may be over one another.

/// Of a letter, and of a line \[units of a drawing\].
const LETTER: f64 = 7.0;
const LINE: f64 = 14.0;
/// Between a point and its name.
const OFF: f64 = 8.0;

/// Where a name stands, seen from its point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Corner {
    /// To the left of it, otherwise to the right.
    pub left: bool,
    /// Below it, otherwise above.
    pub below: bool,
}

impl Corner {
    const ALL: [Self; 4] = [
        Self { left: false, below: false },
        Self { left: true, below: false },
        Self { left: false, below: true },
        Self { left: true, below: true },
    ];

    /// Beginning (or end, of one to the left) of the name and its base line.
    pub fn place(self, (x, y): (f64, f64)) -> (f64, f64) {
        (if self.left { x - OFF } else { x + OFF }, if self.below { y + OFF + 0.7 * LINE } else { y - OFF + 1.0 })
    }

    /// The box of a name of so many letters.
    fn area(self, point: (f64, f64), letters: usize) -> [f64; 4] {
        let ((x, base), width) = (self.place(point), LETTER * letters as f64);
        let from = if self.left { x - width } else { x };
        [from, base - 0.8 * LINE, from + width, base + 0.2 * LINE]
    }
}

/// Corners for names of these lengths at these points, in a frame from (left, top) to (right, bottom).
pub(super) fn placed(points: &[(f64, f64)], letters: &[usize], frame: [f64; 4]) -> Vec<Corner> {
    let mut taken: Vec<[f64; 4]> = Vec::new();
    let both = |a: &[f64; 4], b: &[f64; 4]| {
        let (width, height) = (a[2].min(b[2]) - a[0].max(b[0]), a[3].min(b[3]) - a[1].max(b[1]));
        width.max(0.0) * height.max(0.0)
    };
    let mut found = Vec::new();
    for (point, letters) in points.iter().zip(letters) {
        let cost = |corner: &Corner| {
            let area = corner.area(*point, *letters);
            let size = (area[2] - area[0]) * (area[3] - area[1]);
            let names: f64 = taken.iter().map(|other| both(&area, other)).sum();
            let dots: f64 = points.iter().map(|(x, y)| both(&area, &[x - 5.0, y - 5.0, x + 5.0, y + 5.0])).sum();
            // what is cut off is worse than what is covered
            4.0 * (size - both(&area, &frame)) + names + 2.0 * dots
        };
        let best = Corner::ALL.into_iter().min_by(|a, b| cost(a).total_cmp(&cost(b))).unwrap_or(Corner::ALL[0]);
        taken.push(best.area(*point, *letters));
        found.push(best);
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_keep_within_the_frame_and_off_one_another() {
        let frame = [0.0, 0.0, 800.0, 300.0];
        let [alone, edge, below] = placed(&[(100.0, 100.0), (790.0, 150.0), (400.0, 5.0)], &[10, 10, 10], frame)[..]
        else {
            panic!("three")
        };
        assert_eq!((alone.left, alone.below), (false, false));
        assert!(edge.left && !edge.below, "{edge:?}");
        assert!(below.below, "{below:?}");
        // two points side by side
        let near = placed(&[(200.0, 200.0), (230.0, 200.0)], &[12, 12], frame);
        assert_ne!(near[0], near[1]);
    }
}
