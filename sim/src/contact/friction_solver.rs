//! Which elements stick and which slide, decided anew at an event.
//!
//! At one instant, the accelerations are those that minimise ½ (a − a₀)ᵀ M (a − a₀) + Σ limit |J a|
//! over the elements that stand: the principle of least constraint with Coulomb friction, which has
//! one solution. It is found element by element (block Gauss–Seidel on the forces): each in turn gets
//! the force inside its disc that suits the others' best. In plain numbers: what follows from the
//! decision is computed with derivatives by the operator of the new set.

use crate::parts::friction_elements::{ELEMENTS, Element, ElementSet};
use crate::parts::scalar::{Matrix, Pair, Scalar, Vector};
use crate::robot::body::Mode;
use crate::robot::{GRAVITY_M_S2, Robot};

/// Steps of Newton's method on one disc; it doubles the digits from the first.
const NEWTON: usize = 30;

/// Share of the accelerations in play below which one counts as none.
const AT_REST: f64 = 1e-8;

/// The elements that stand, the forces on the robot, and what answers.
pub(crate) struct FrictionProblem<'a, S> {
    pub(crate) robot: &'a Robot<S>,
    pub(crate) mode: &'a Mode<S>,
    /// M⁻¹ projected on what the elements leave free that cannot slide.
    pub(crate) mobility: Matrix<f64>,
    /// Force without dry friction of loose elements.
    pub(crate) applied: Vector<f64>,
    /// Acceleration that exact wheel speeds force on the robot.
    pub(crate) forced: Vector<f64>,
    /// Velocities.
    pub(crate) nu: Vector<f64>,
    /// Loose elements that stand: they may stick or begin to slide.
    pub(crate) candidates: ElementSet,
    /// Lateral multiplier of wheels that cannot slide, per unit of each force.
    pub(crate) across: Vector<f64>,
}

/// How the robot answers to unit forces at one element.
#[derive(Clone, Copy, Default)]
struct ConstraintResponse {
    /// What the element sees of a velocity.
    rows: [Vector<f64>; 2],
    /// Acceleration of the robot by a unit force along each row.
    responses: [Vector<f64>; 2],
    /// What the element sees of its own unit forces: J M⁻¹ Jᵀ, by its upper triangle.
    own: [f64; 3],
}

/// What was decided: elements that stick, and the directions in which the others set off.
pub(crate) struct ContactModes {
    pub(crate) sticking: ElementSet,
    pub(crate) direction: [Pair<f64>; ELEMENTS],
}

impl<S: Scalar> FrictionProblem<'_, S> {
    /// Decides for each candidate whether it sticks. Those in `broken` have broken away.
    pub(crate) fn decide(&self, broken: ElementSet) -> ContactModes {
        let mut force = [[0.0; 2]; ELEMENTS];
        let mut responses_of = [ConstraintResponse::default(); ELEMENTS];
        for element in self.candidates.iter() {
            responses_of[element as usize] = self.touch(element);
        }
        let mut sliding = self.candidates.both(broken);
        loop {
            let acceleration = self.solve(sliding, &responses_of, &mut force);
            let scale = self.mobility_scale();
            let sets_off = |element: Element| {
                let [along, across] = self.seen(element, &acceleration);
                along.hypot(across) > AT_REST * scale
            };
            let set_off = self.candidates.iter().filter(|&element| sets_off(element));
            let now = set_off.fold(sliding, ElementSet::with);
            if now == sliding {
                return self.decision(&force, sliding);
            }
            sliding = now;
        }
    }

    fn touch(&self, element: Element) -> ConstraintResponse {
        let mut touch = ConstraintResponse::default();
        for (at, &row) in element.rows().iter().enumerate() {
            touch.rows[at] = self.row(row);
            touch.responses[at] = self.mobility * touch.rows[at];
        }
        let own = |one: usize, other: usize| touch.rows[one].dot(&touch.responses[other]);
        touch.own = [own(0, 0), own(0, 1), own(1, 1)];
        touch
    }

    /// What slides does so against its force.
    fn decision(&self, force: &[Pair<f64>; ELEMENTS], sliding: ElementSet) -> ContactModes {
        let mut decision = ContactModes {
            sticking: self.candidates,
            direction: [[0.0; 2]; ELEMENTS],
        };
        for element in sliding.iter() {
            let [along, across] = force[element as usize];
            let size = along.hypot(across);
            if size > 0.0 {
                decision.sticking = decision.sticking.without(element);
                decision.direction[element as usize] = [-along / size, -across / size];
            }
        }
        decision
    }

    /// Accelerations that matter beside this are not zero (m/s² or rad/s²).
    fn mobility_scale(&self) -> f64 {
        let free = self.mobility * self.applied;
        free.iter()
            .fold(GRAVITY_M_S2 * 1e-3, |most: f64, a| most.max(a.abs()))
    }

    /// The accelerations, with normal forces that agree with the lateral forces.
    fn solve(
        &self,
        sliding: ElementSet,
        responses_of: &[ConstraintResponse; ELEMENTS],
        force: &mut [Pair<f64>; ELEMENTS],
    ) -> Vector<f64> {
        let load = &self.robot.load;
        let driven = load.driven.value();
        let mut normal = [driven / 2.0; 2];
        for _ in 0..self.robot.tolerances.normal_iterations {
            let limits = self.limits(sliding, normal);
            let acceleration = self.sweep(&limits, responses_of, force);
            let total = self.total(&limits, force);
            let across: f64 = Element::WHEELS
                .iter()
                .map(|&wheel| force[wheel as usize][1])
                .sum();
            let across = across + self.across.dot(&total);
            let surge = acceleration[0] - self.nu[1] * self.nu[2];
            let transfer = load.transfer.map_or(0.0, |t| t.value() * surge);
            let whole = (driven + transfer).clamp(0.0, load.total.value());
            let apart = load.lateral.value() * across + load.offset.value();
            let apart = apart.clamp(-whole, whole);
            let next = [(whole + apart) / 2.0, (whole - apart) / 2.0];
            let change = (next[0] - normal[0]).abs().max((next[1] - normal[1]).abs());
            normal = next;
            if change <= 1e-12 * load.total.value() {
                return acceleration;
            }
        }
        self.sweep(&self.limits(sliding, normal), responses_of, force)
    }

    /// Friction limit of each loose element (N or N m): static for what sticks so far.
    fn limits(&self, sliding: ElementSet, normal: Pair<f64>) -> [f64; ELEMENTS] {
        let mut limits = [0.0; ELEMENTS];
        let caster = self.robot.load.total.value() - normal[0] - normal[1];
        for element in self.mode.loose.iter() {
            let i = element as usize;
            limits[i] = match (element, self.mode.grip.get(i)) {
                (Element::WheelRight | Element::WheelLeft, Some(Some(grip))) => {
                    let stands = self.candidates.has(element) && !sliding.has(element);
                    let friction = if stands {
                        grip.friction_static
                    } else {
                        grip.friction_kinetic
                    };
                    friction.value() * normal[i]
                }
                _ => self.robot.dry_limit(element, S::constant(caster)).value(),
            };
        }
        limits
    }

    /// All forces: applied, of elements that slide, of those that stand.
    fn total(&self, limits: &[f64; ELEMENTS], force: &mut [Pair<f64>; ELEMENTS]) -> Vector<f64> {
        let mut total = self.applied;
        for element in self.mode.loose.iter() {
            let i = element as usize;
            if !self.candidates.has(element) {
                let [along, across] = self.seen(element, &self.nu);
                let size = along.hypot(across).max(f64::MIN_POSITIVE);
                force[i] = [-limits[i] * along / size, -limits[i] * across / size];
            }
            for (&row, part) in element.rows().iter().zip(force[i]) {
                total += self.row(row) * part;
            }
        }
        total
    }

    /// Each candidate's best answer to the others', until none changes.
    fn sweep(
        &self,
        limits: &[f64; ELEMENTS],
        responses_of: &[ConstraintResponse; ELEMENTS],
        force: &mut [Pair<f64>; ELEMENTS],
    ) -> Vector<f64> {
        let total = self.total(limits, force);
        let mut acceleration = self.mobility * total + self.forced;
        let scale = self.mobility_scale();
        for _ in 0..self.robot.tolerances.sweeps {
            let mut change: f64 = 0.0;
            for element in self.candidates.iter() {
                let i = element as usize;
                let touch = &responses_of[i];
                let best = self.best(element, touch, limits[i], force[i], &acceleration);
                let responses = &touch.responses[..element.rows().len()];
                for (at, response) in responses.iter().enumerate() {
                    let more = best[at] - force[i][at];
                    force[i][at] = best[at];
                    let response = response * more;
                    acceleration += response;
                    change = change.max(response.amax());
                }
            }
            if change <= 1e-5 * AT_REST * scale {
                break;
            }
        }
        acceleration
    }

    /// The force inside the disc of radius `limit` that leaves the element at rest, or opposes its
    /// acceleration: p with W p + q = −s p, s ≥ 0, where W = J M⁻¹ Jᵀ and q is the acceleration
    /// without this element. |p| falls with s: the root of 1/|p| − 1/limit, by Newton's method.
    fn best(
        &self,
        element: Element,
        touch: &ConstraintResponse,
        limit: f64,
        own: Pair<f64>,
        acceleration: &Vector<f64>,
    ) -> Pair<f64> {
        let [a, b, d] = touch.own;
        let along = touch.rows[0].dot(acceleration);
        if element.rows().len() == 1 || self.is_led(element) {
            let rest = own[0] - along / a;
            return if a > 0.0 {
                [rest.clamp(-limit, limit), 0.0]
            } else {
                own
            };
        }
        if a * d - b * b <= 0.0 {
            return own;
        }
        let seen = [along, touch.rows[1].dot(acceleration)];
        let q = [
            seen[0] - a * own[0] - b * own[1],
            seen[1] - b * own[0] - d * own[1],
        ];
        let solve = |s: f64, [x, y]: Pair<f64>| {
            let (a, d) = (a + s, d + s);
            let per = (a * d - b * b).recip();
            [(b * y - d * x) * per, (b * x - a * y) * per]
        };
        let mut s = 0.0;
        let mut p = solve(s, q);
        for _ in 0..NEWTON {
            let size = (p[0] * p[0] + p[1] * p[1]).sqrt();
            if size <= limit * (1.0 + 1e-15) {
                break;
            }
            let slope = solve(s, p);
            let falls = -(p[0] * slope[0] + p[1] * slope[1]);
            if limit == 0.0 || falls <= 0.0 {
                return [0.0; 2];
            }
            s += (size - limit) / limit * size * size / falls;
            p = solve(s, q);
        }
        p
    }

    fn row(&self, row: usize) -> Vector<f64> {
        self.robot.row(row).map(|entry| entry.value())
    }

    /// Whether the element is a wheel beside one that cannot slide, and so does not go across.
    fn is_led(&self, element: Element) -> bool {
        match element {
            Element::WheelRight => !self.mode.loose.has(Element::WheelLeft),
            Element::WheelLeft => !self.mode.loose.has(Element::WheelRight),
            _ => false,
        }
    }

    /// What an element sees of a velocity or an acceleration.
    fn seen(&self, element: Element, nu: &Vector<f64>) -> Pair<f64> {
        let rows = element.rows();
        let along = self.row(rows[0]).dot(nu);
        let across = rows.get(1).filter(|_| !self.is_led(element));
        [along, across.map_or(0.0, |&row| self.row(row).dot(nu))]
    }
}
