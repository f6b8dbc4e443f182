//! How an effect shows in a recording: what a search for it has to heed, and what shows it best.

/// When an effect acts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum When {
    /// At all times, and little by little more with its numbers.
    Always,
    /// While a wheel slides: a friction that is far off says nothing of which way the true one lies.
    Sliding,
    /// On one piece of floor, whose friction it replaces.
    Inside,
    /// Once, for a moment.
    Once,
    /// On commands below a threshold; of commands there are only so many, so that nothing has a
    /// derivative.
    Below,
    /// On commands above a limit: the less, the larger that is, and nothing from some size on.
    Above,
    /// While gears are apart.
    Apart,
}

/// What the force or the moment of an effect follows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Variable {
    /// Speed along the body, v.
    Speed,
    /// Turn rate, w.
    TurnRate,
    /// Heading, φ.
    Heading,
    /// What the wheels are told.
    Command,
}

/// A manoeuvre whose recording shows an effect.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Manoeuvre {
    /// What slows the body down.
    CoastDown,
    /// What sits between motor and wheel.
    LiftedWheels,
    /// What masses and torques do.
    AddedMass,
    /// What changes over minutes.
    SameAgain,
    /// What becomes of small, large and changing commands.
    Steps,
    /// What turning shows.
    SpinInPlace,
    /// What weight does on a slope.
    Ramp,
    /// What a turn of a wheel means.
    HandTurned,
    /// What friction holds.
    UntilItSlips,
    /// What the clocks say.
    SharpStarts,
    /// What a message's way takes.
    Follow,
    /// What came from outside.
    NobodyNear,
}

impl Manoeuvre {
    /// How to do it.
    pub fn words(self) -> &'static str {
        match self {
            Self::CoastDown => {
                "coast-down: drive straight at the highest speed, then command nothing until it stands"
            }
            Self::LiftedWheels => {
                "lifted wheels: the same commands with the wheels off the floor show what sits in the \
                 drive train"
            }
            Self::AddedMass => {
                "known added mass: the same commands with a weighed mass at a measured place"
            }
            Self::SameAgain => {
                "stop-and-go over several minutes with the same commands again and again"
            }
            Self::Steps => {
                "stop-and-go: steps of the command from the smallest to the largest, in both directions"
            }
            Self::SpinInPlace => "spin in place: several turns left and several right",
            Self::Ramp => "known ramp, or the same line driven in four directions",
            Self::HandTurned => {
                "ten hand-turned revolutions of each wheel with the encoders read (scale of the \
                 counts), then a measured straight line (radius)"
            }
            Self::UntilItSlips => {
                "stop-and-go with commands that rise until the wheels slip, at several places of the \
                 floor"
            }
            Self::SharpStarts => {
                "stop-and-go with encoders, camera and commands recorded: sharp starts mark every \
                 clock, over minutes its drift"
            }
            Self::Follow => {
                "stop-and-go of the robot in front, with both robots in the camera's view"
            }
            Self::NobodyNear => "the same commands again, with nobody near",
        }
    }
}
