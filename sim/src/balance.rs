//! Forces at one instant: what the floor answers to a motion and to the forces that act on it.

use crate::effects::{Motion, Wrench};
use crate::operator::Operator;
use crate::robot::Robot;
use crate::rows::{ACROSS, ALONG_LEFT, ALONG_RIGHT, Element, Elements};
use crate::scalar::{Pair, Scalar, Vector, clamp, heading, length};
use crate::state::{Contact, Mode};

/// Slip below which the direction of sliding is the one in which it began (m/s or rad/s).
pub(crate) const STANDING: f64 = 1e-13;

/// All forces on a robot at one instant.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Balance<S> {
    /// Generalised force without the multipliers of held rows.
    pub(crate) force: Vector<S>,
    /// Forces at the driven wheels.
    pub(crate) contact: Contact<S>,
}

impl<S: Scalar> Robot<S> {
    /// Forces that do not depend on what sticks or slides: inertial forces of Eq. 3 in the body
    /// frame, weight on a slope, effects, and the torque of the motors.
    #[inline]
    pub(crate) fn applied(
        &self,
        nu: &Vector<S>,
        yaw: S,
        span: Pair<f64>,
        torque: Pair<S>,
    ) -> Vector<S> {
        let (m, [sx, sy]) = (self.mass, self.moment);
        let (u, w, rate) = (nu[0], nu[1], nu[2]);
        // m13, m23 and the φ̇² terms of Eq. 3, turned into the body frame
        let along = (m * w + sx * rate) * rate;
        let across = (sy * rate - m * u) * rate;
        let moment = -(sx * u + sy * w) * rate;
        let mut wrench = Wrench {
            along,
            across,
            moment,
        };
        if self.pull.is_some() || self.effects.has_force {
            self.external(nu, yaw, span, &mut wrench);
        }
        Vector::from([
            wrench.along,
            wrench.across,
            wrench.moment,
            torque[0],
            torque[1],
        ])
    }

    /// Weight on a slope and the forces of effects.
    fn external(&self, nu: &Vector<S>, yaw: S, span: Pair<f64>, wrench: &mut Wrench<S>) {
        let [cos, sin] = heading(yaw);
        if let Some([x, y]) = self.pull {
            let (along, across) = (x * cos + y * sin, y * cos - x * sin);
            let [sx, sy] = self.moment;
            wrench.along += self.mass * along;
            wrench.across += self.mass * across;
            wrench.moment += sx * across - sy * along;
        }
        let [t_s, over_s] = span;
        let velocity = [nu[0], nu[1]];
        let motion = Motion {
            t_s,
            over_s,
            heading: [cos, sin],
            velocity,
        };
        self.effects.force(&motion, wrench);
    }

    /// Adds dry friction of moving elements and the forces at the driven wheels to `applied`. `forced`
    /// is the surge acceleration that no force of these gives (m/s²).
    #[inline]
    pub(crate) fn balance(
        &self,
        mode: &Mode<S>,
        operator: &Operator<S>,
        nu: &Vector<S>,
        applied: Vector<S>,
        forced: S,
    ) -> Balance<S> {
        if self.dry.elements.is_empty() {
            return self.at_wheels(mode, operator, nu, applied, forced);
        }
        if self.load.transfer.is_none() {
            let caster = self.load.total - self.load.driven;
            let force = self.with_dry(mode, nu, applied, caster);
            return self.at_wheels(mode, operator, nu, force, forced);
        }
        // Caster friction and load transfer act on each other: a contraction by about μ h / (d + e)
        let mut caster = self.load.total - self.load.driven;
        loop {
            let force = self.with_dry(mode, nu, applied, caster);
            let balance = self.at_wheels(mode, operator, nu, force, forced);
            let [right, left] = balance.contact.normal_n;
            let next = self.load.total - right - left;
            let change = (next - caster).value().abs();
            caster = next;
            if change <= 1e-13 * self.load.total.value() || change.is_nan() {
                return balance;
            }
        }
    }

    /// Adds the friction of moving axles, body and caster.
    fn with_dry(
        &self,
        mode: &Mode<S>,
        nu: &Vector<S>,
        mut force: Vector<S>,
        caster_normal: S,
    ) -> Vector<S> {
        for element in self.dry.elements.iter() {
            if !mode.slides(element) {
                continue;
            }
            let limit = self.dry_limit(element, caster_normal);
            let direction = self.direction(mode, element, nu);
            for (&row, part) in element.rows().iter().zip(direction) {
                force -= self.row(row) * (limit * part);
            }
        }
        force
    }

    /// Unit direction in which a sliding element slides.
    #[inline]
    pub(crate) fn direction(&self, mode: &Mode<S>, element: Element, nu: &Vector<S>) -> Pair<S> {
        let mut seen = self.seen(element, nu);
        if mode.is_led(element) {
            seen[1] = S::constant(0.0);
        }
        let size = length(seen);
        if size.value() <= STANDING {
            return mode.direction[element as usize];
        }
        let per = size.recip();
        [seen[0] * per, seen[1] * per]
    }

    /// Normal forces, coupled with the contact forces of the same instant, and those forces.
    #[inline]
    fn at_wheels(
        &self,
        mode: &Mode<S>,
        operator: &Operator<S>,
        nu: &Vector<S>,
        force: Vector<S>,
        forced: S,
    ) -> Balance<S> {
        let zero = S::constant(0.0);
        let held = !mode.held.both(Elements::WHEELS).is_empty();
        let (mut along, mut across) = ([zero; 2], zero);
        if held {
            along = [
                operator.multiplier(ALONG_RIGHT, &force),
                operator.multiplier(ALONG_LEFT, &force),
            ];
            across = operator.multiplier(ACROSS, &force);
        }
        let slides = [
            mode.slides(Element::WheelRight),
            mode.slides(Element::WheelLeft),
        ];
        if slides == [false; 2] && self.load.transfer.is_none() {
            let unneeded = mode.grip == [None; 2] && self.dry.caster.is_none();
            let normal_n = if unneeded {
                [zero; 2]
            } else {
                let shift = self.load.lateral * across + self.load.offset;
                self.share(self.load.driven, shift)
            };
            let contact = Contact {
                normal_n,
                along_n: along,
                across_n: across,
            };
            return Balance { force, contact };
        }
        // Force per newton of normal force at each sliding wheel, and what held rows answer to it
        let mut per_newton = [[zero; 2]; 2];
        let mut pull = [Vector::from([zero; 5]); 2];
        let mut responds = [zero; 2];
        for i in 0..2 {
            if let (true, Some(grip)) = (slides[i], mode.grip[i]) {
                let [x, y] = self.direction(mode, Element::WHEELS[i], nu);
                let friction = -grip.friction_kinetic;
                per_newton[i] = [friction * x, friction * y];
                pull[i] = self.pull_of(i, per_newton[i]);
                responds[i] = per_newton[i][1];
                if held {
                    responds[i] += operator.multiplier(ACROSS, &pull[i]);
                }
            }
        }
        let surge = self.load.transfer.map(|transfer| {
            let rate = |f: &Vector<S>| operator.acceleration.row(0).transpose().dot(f);
            (
                transfer,
                forced + rate(&force) - nu[1] * nu[2],
                [rate(&pull[0]), rate(&pull[1])],
            )
        });
        let normal = self.normal(across, responds, surge);
        let force = force + pull[0] * normal[0] + pull[1] * normal[1];
        let mut along_n = [per_newton[0][0] * normal[0], per_newton[1][0] * normal[1]];
        if held {
            along_n[0] += operator.multiplier(ALONG_RIGHT, &force);
            along_n[1] += operator.multiplier(ALONG_LEFT, &force);
        }
        let across_n = across + responds[0] * normal[0] + responds[1] * normal[1];
        Balance {
            force,
            contact: Contact {
                normal_n: normal,
                along_n,
                across_n,
            },
        }
    }

    /// The generalised force of a force [along, across] at the contact of wheel `i`.
    #[inline]
    fn pull_of(&self, i: usize, [along, across]: Pair<S>) -> Vector<S> {
        let zero = S::constant(0.0);
        let lever = self.half_track * along;
        let moment = if i == 0 { lever } else { -lever } - self.com_to_axle * across;
        let spin = -self.radius[i] * along;
        let spin = if i == 0 { [spin, zero] } else { [zero, spin] };
        Vector::from([along, across, moment, spin[0], spin[1]])
    }

    /// N_r and N_l (Eq. 4 to 6) when the lateral force is `across` + Σ `per_normal` N and, with
    /// load transfer, the longitudinal acceleration is affine in N likewise.
    #[inline]
    fn normal(&self, across: S, per_normal: Pair<S>, surge: Option<(S, S, Pair<S>)>) -> Pair<S> {
        let zero = S::constant(0.0);
        let half = |[a, b]: Pair<S>| ((a + b) * 0.5, (a - b) * 0.5);
        let (sum, difference) = half(per_normal);
        let lateral = self.load.lateral;
        // N_r − N_l = shift + tilt (N_r + N_l)
        let own = (S::constant(1.0) - lateral * difference).recip();
        let shift = (lateral * across + self.load.offset) * own;
        let tilt = lateral * sum * own;
        let driven = surge.map_or(self.load.driven, |(transfer, free, per_normal)| {
            let (sum, difference) = half(per_normal);
            let rest = self.load.driven + transfer * (free + difference * shift);
            let whole = rest / (S::constant(1.0) - transfer * (sum + difference * tilt));
            clamp(whole, zero, self.load.total)
        });
        self.share(driven, shift + tilt * driven)
    }

    /// N_r and N_l of this sum and difference. A wheel that would lift carries nothing.
    #[inline]
    fn share(&self, sum: S, difference: S) -> Pair<S> {
        let apart = clamp(difference, -sum, sum);
        [(sum + apart) * 0.5, (sum - apart) * 0.5]
    }
}
