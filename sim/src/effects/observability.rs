//! Observability of an effect in a recording: when and as a function of what it acts, and the
//! manoeuvre that shows it best.

/// When an effect acts, which determines how a search may treat its parameters.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum When {
    /// At all times, smoothly in its parameters.
    Always,
    /// While a wheel slides: far from the true friction the gradient does not point towards it.
    Sliding,
    /// While a wheel is on one part of the floor, whose friction it replaces.
    Inside,
    /// Once, for a short time.
    Once,
    /// On commands below a threshold: a recording has finitely many commands, so that the threshold
    /// has no derivative.
    Below,
    /// On commands above a limit: a limit above all commands has no effect.
    Above,
    /// While the gears are open.
    Apart,
}

/// Variable of which the force or moment of an effect is a function.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Variable {
    /// Speed along the body, v.
    Speed,
    /// Yaw rate, w.
    TurnRate,
    /// Heading, φ.
    Heading,
    /// Command at the wheels.
    Command,
}

/// A manoeuvre whose recording shows an effect.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Manoeuvre {
    /// For forces that slow the body down.
    CoastDown,
    /// For the drive train between motor and wheel.
    LiftedWheels,
    /// For masses and torques, of which motion shows only the ratio.
    AddedMass,
    /// For changes over minutes.
    SameAgain,
    /// For the response to small, large and changing commands.
    Steps,
    /// For resistance and geometry in turns.
    SpinInPlace,
    /// For gravity on a slope.
    Ramp,
    /// For wheel radii and encoder scales.
    HandTurned,
    /// For friction of the driven wheels.
    UntilItSlips,
    /// For latencies and clocks.
    SharpStarts,
    /// For delays of messages.
    Follow,
    /// For forces from outside.
    NobodyNear,
}

impl Manoeuvre {
    /// Instruction for carrying it out, as it appears in answers.
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
