//! What a file says about the drive of a robot: the lengths with which its controller reckons, and its wheels.
//!
//! Parameters of controllers, plugins of simulators and constants of programs say the same in different words.

use super::measured_in::in_metres;
use super::parameter_names::Quantity;
use super::words::in_words;

/// Lengths that differ by less, relative to the larger, are the same: files round.
const SAME: f64 = 0.005;

/// A length, and where the file says it.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Length {
    pub(super) value_m: f64,
    pub(super) from: String,
}

impl Length {
    pub(super) fn new(value_m: f64, from: impl Into<String>) -> Self {
        Self {
            value_m,
            from: from.into(),
        }
    }

    /// A part or a multiple of it, said in words such as `half of`.
    pub(super) fn times(&self, factor: f64, words: &str) -> Self {
        Self::new(self.value_m * factor, format!("{words} {}", self.from))
    }

    /// Whether another is the same but for rounding.
    fn is_near(&self, other: &Self) -> bool {
        let larger = self.value_m.abs().max(other.value_m.abs());
        (self.value_m - other.value_m).abs() <= SAME * larger
    }
}

/// How a robot moves.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) enum Sort {
    /// By the difference of its wheels; skid steering, too.
    #[default]
    Differential,
    /// By tracks.
    Tracked,
    /// By mecanum wheels: also sideways.
    Mecanum,
    /// By omni wheels, or by a plugin that moves the body: in any direction.
    Omni,
    /// By wheels that steer.
    Steered,
}

impl Sort {
    /// The sort that words of a type, a plugin or a link name.
    pub(super) fn of_words(text: &str) -> Option<Self> {
        let text = text.to_lowercase();
        let has = |words: &[&str]| words.iter().any(|word| text.contains(word));
        if has(&["mecanum"]) {
            Some(Self::Mecanum)
        } else if has(&["omni", "planarmove", "planar_move", "holonomic"]) {
            Some(Self::Omni)
        } else if has(&["ackermann", "bicycle", "tricycle", "steering", "swerve"])
            && !has(&["skid"])
        {
            Some(Self::Steered)
        } else if has(&[
            "tracked",
            "trackcontroller",
            "track-controller",
            "track_controller",
        ]) {
            Some(Self::Tracked)
        } else if has(&["diff", "skid"]) {
            Some(Self::Differential)
        } else {
            None
        }
    }

    /// What a person must know of a robot of this sort before its model is used.
    pub(super) fn warning(self) -> Option<&'static str> {
        match self {
            Self::Differential => None,
            Self::Tracked => Some(
                "Tracks: the model has one pair of wheels. Tracks turn as if they were farther apart, which `slipstream \
                 diagnose` finds as track_width",
            ),
            Self::Mecanum => Some(
                "Mecanum wheels are no differential drive: the model fits only while the robot is told no sideways speed",
            ),
            Self::Omni => Some(
                "A robot that moves sideways is no differential drive: the model fits only while it is told no sideways speed",
            ),
            Self::Steered => Some(
                "A robot with steered wheels is no differential drive: the model is that of the axle that does not steer, and \
                 fits its wheels, not what its steering is told",
            ),
        }
    }
}

/// Factors by which a controller multiplies its lengths.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Multipliers {
    pub(super) track: f64,
    /// Right and left.
    pub(super) radii: [f64; 2],
}

impl Default for Multipliers {
    fn default() -> Self {
        Self {
            track: 1.0,
            radii: [1.0; 2],
        }
    }
}

impl Multipliers {
    /// In words, such as `track by 1.8, radii by 0.9`; `None` if there are none.
    pub(super) fn in_words(&self) -> Option<String> {
        let [right, left] = self.radii;
        let mut words = Vec::new();
        if self.track != 1.0 {
            words.push(format!("the track by {}", self.track));
        }
        if self.radii != [1.0; 2] {
            words.push(match right == left {
                true => format!("the radii by {right}"),
                false => format!("the right radius by {right} and the left by {left}"),
            });
        }
        (!words.is_empty()).then(|| words.join(", "))
    }

    /// The mean of the wheels' multipliers, exact if they are the same.
    pub(super) fn mean_radius(&self) -> f64 {
        let [right, left] = self.radii;
        if right == left {
            right
        } else {
            (right + left) / 2.0
        }
    }
}

/// What a file says about a drive.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Drive {
    /// What says it, such as the name of a controller.
    pub(super) name: String,
    /// The type that it names.
    pub(super) type_name: Option<String>,
    pub(super) sort: Sort,
    /// Distance of the wheels.
    pub(super) separation: Option<Length>,
    pub(super) radius: Option<Length>,
    pub(super) multipliers: Multipliers,
    /// Names of the wheel joints, right and left.
    pub(super) joints: [Vec<String>; 2],
    /// Whether there are several wheels on a side.
    pub(super) has_several: bool,
    /// Encoder counts per turn of a wheel, and where the file says it.
    pub(super) counts_per_rev: Option<(f64, String)>,
    /// What was assumed.
    pub(super) notes: Vec<String>,
    /// What is called a wheelbase: mostly a distance along the robot, else that of its wheels.
    pub(super) wheelbase: Option<Length>,
}

impl Drive {
    pub(super) fn named(name: impl Into<String>) -> Self {
        Self {
            name: name.into(),
            ..Self::default()
        }
    }

    /// Takes a number that a file calls `key`, in the unit that the key names. The first of several counts.
    ///
    /// # Errors
    /// What is wrong, if the number is in no known unit.
    pub(super) fn take(
        &mut self,
        key: &str,
        (quantity, unit_m): (Quantity, Option<f64>),
        value: f64,
    ) -> Result<(), String> {
        let mut from = format!("{key} of {}", self.name);
        if quantity == Quantity::CountsPerTurn {
            self.counts_per_rev.get_or_insert((value, from));
            return Ok(());
        }
        let own = in_metres(value, quantity, unit_m)?;
        if own.is_from_mm {
            self.notes.push(format!(
                "{from} is {value}: it counts as millimetres, since no robot has it in metres"
            ));
            from.push_str(", in millimetres");
        }
        let length = Length::new(own.value_m, from);
        let (place, length) = match quantity {
            Quantity::Separation => (&mut self.separation, length),
            Quantity::Wheelbase => (&mut self.wheelbase, length),
            Quantity::Diameter => (&mut self.radius, length.times(0.5, "half of")),
            _ => (&mut self.radius, length),
        };
        place.get_or_insert(length);
        Ok(())
    }

    /// The drive when everything was taken: without another distance of its wheels, the wheelbase counts.
    pub(super) fn complete(mut self) -> Self {
        if let (None, Some(length)) = (&self.separation, self.wheelbase.take()) {
            self.notes.push(format!(
                "{} counts as the distance between the left and right wheels",
                length.from
            ));
            self.separation = Some(length);
        }
        self
    }

    /// Half of the distance of its wheels.
    pub(super) fn half_track(&self) -> Option<Length> {
        self.separation
            .as_ref()
            .map(|own| own.times(0.5, "half of"))
    }

    /// Whether it says both lengths.
    pub(super) fn has_lengths(&self) -> bool {
        self.separation.is_some() && self.radius.is_some()
    }

    /// Whether it says anything about a drive.
    pub(super) fn says_something(&self) -> bool {
        self.separation.is_some()
            || self.radius.is_some()
            || self.multipliers != Multipliers::default()
            || self.joints.iter().any(|side| !side.is_empty())
    }
}

/// The first of several lengths that is known, and what to say of those that contradict it.
pub(super) fn first_of(
    what: &str,
    lengths: impl IntoIterator<Item = Option<Length>>,
) -> (Option<Length>, Vec<String>) {
    let mut known = lengths.into_iter().flatten();
    let Some(first) = known.next() else {
        return (None, Vec::new());
    };
    let others = known.filter(|other| !first.is_near(other));
    let notes = others
        .map(|other| {
            format!(
                "The files contradict each other about {what}: {} ({}) is taken, not {} ({})",
                in_words(first.value_m),
                first.from,
                in_words(other.value_m),
                other.from
            )
        })
        .collect();
    (Some(first), notes)
}
