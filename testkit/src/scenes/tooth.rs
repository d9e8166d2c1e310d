//! Tooth flanks from the law of gearing.
//!
//! A toothed body of pitch radius R that turns while a rack slides past it by the arc R · angle
//! stays in touch with a point of the rack when the rack's normal there passes through the pitch
//! point. A plane section of a worm slides like a
//! rack when the worm turns, so it gives the wheel that meshes with that worm, section by section.

use glam::DVec3;

/// Tangent of the pressure angle, 20°.
pub(crate) const TAN_PRESSURE: f64 = 0.363_970_234_266_202_4;
/// How deep the smooth flanks of a meshing pair overlap. Faceted gears that only touch in theory
/// would miss each other in most frames.
pub(crate) const INTERFERENCE: f64 = 0.03;

/// A point in cylinder coordinates about the gear's axis, z.
#[derive(Clone, Copy)]
pub(crate) struct Cyl {
    pub(crate) r: f64,
    pub(crate) angle: f64,
    pub(crate) z: f64,
}

impl Cyl {
    pub(crate) fn point(self) -> DVec3 {
        let (sin, cos) = libm::sincos(self.angle);
        DVec3::new(self.r * cos, self.r * sin, self.z)
    }
}

/// A flank of a rack tooth that points at the gear, in the plane z = `z`.
pub(crate) trait RackFlank {
    /// The flank's tangential coordinate at `height` above the pitch circle, and its derivative.
    fn at(&self, side: f64, height: f64, z: f64) -> (f64, f64);
}

/// One pitch of a gear, from the middle of a gap to the middle of the next, in one plane.
pub(crate) struct Section {
    pub(crate) teeth: usize,
    pub(crate) z: f64,
    /// Heights above the pitch circle of the gap's floor (negative) and of the tooth's top.
    pub(crate) floor: f64,
    pub(crate) top: f64,
    /// The lowest and the highest height at which the rack has a flank.
    pub(crate) rack: [f64; 2],
}

/// Numbers of steps along one pitch.
#[derive(Clone, Copy)]
pub(crate) struct Steps {
    pub(crate) floor: usize,
    pub(crate) flank: usize,
    pub(crate) top: usize,
}

impl Steps {
    /// Steps of a whole pitch.
    pub(crate) fn total(self) -> usize {
        self.floor + 2 * self.flank + self.top
    }
}

impl Section {
    /// The `steps.total()` points of the section that meshes with `rack`, counter-clockwise; the
    /// rack's tooth stands in the middle of the gap at angle 0.
    pub(crate) fn points(&self, rack: &impl RackFlank, steps: Steps) -> Vec<Cyl> {
        let pitch = std::f64::consts::TAU / self.teeth as f64;
        let rising = self.flank(rack, 1.0, steps.flank);
        let mut falling = self.flank(rack, -1.0, steps.flank);
        falling.reverse();
        let floor = self.radius() + self.floor;
        let arc = |from: f64, to: f64, r: f64, n: usize| {
            (1..n).map(move |k| Cyl {
                r,
                angle: from + (to - from) * k as f64 / n as f64,
                z: self.z,
            })
        };
        let [gap_from, gap_to] = [falling[steps.flank].angle, rising[0].angle];
        let [top_from, top_to] = [rising[steps.flank].angle, falling[0].angle + pitch];
        let mut points = rising;
        points.extend(arc(top_from, top_to, self.radius() + self.top, steps.top));
        points.extend(falling.iter().map(|p| Cyl { angle: p.angle + pitch, ..*p }));
        points.extend(arc(gap_from + pitch, gap_to + pitch, floor, steps.floor));
        points
    }

    fn radius(&self) -> f64 {
        self.teeth as f64 / 2.0
    }

    /// The `steps` + 1 points of one flank, from the gap's floor to the tooth's top.
    fn flank(&self, rack: &impl RackFlank, side: f64, steps: usize) -> Vec<Cyl> {
        let [low, mut high] = self.rack;
        let top = self.radius() + self.top;
        // Unless undercut, the radius grows with the rack's height: bisection finds the top.
        let mut inside = low;
        for _ in 0..52 {
            let middle = (inside + high) / 2.0;
            if self.conjugate(rack, side, middle).r < top { inside = middle } else { high = middle }
        }
        let height = |k: usize| low + (high - low) * k as f64 / steps as f64;
        (0..=steps).map(|k| self.conjugate(rack, side, height(k))).collect()
    }

    /// The point of the gear that meets the rack's flank at `height`.
    fn conjugate(&self, rack: &impl RackFlank, side: f64, height: f64) -> Cyl {
        let (t, slope) = rack.at(side, height, self.z);
        // They meet where the flank has slid so far that its normal passes through the pitch point.
        let met = -height / slope;
        let [x, y] = [self.radius() + height, met];
        let angle = libm::atan2(y, x) - (met - t) / self.radius();
        Cyl { r: libm::hypot(x, y), angle, z: self.z }
    }
}
