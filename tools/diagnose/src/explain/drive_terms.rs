//! The terms of a drive, with what nobody would call a difference.

use super::term::{
    BAND_TERM, CLOCK_TERM, DELAY_TERM, GAIN_TERM, LAG_TERM, RATE_CAUTION, SAG_TERM,
    SATURATION_TERM, SLOW_TERM, ZONE_TERM, term,
};
use crate::model::command_to_wheels::CommandToWheels;
use crate::model::drive::{
    CLOCK, DEAD_BAND, DEAD_ZONE, DELAY, GAIN, GAIN_ASYMMETRY, LAG, SAG, SATURATION, SLOW_SHARE,
    SLOW_TIME,
};
use crate::select::elimination::Term;

/// Dead zone from which it starts, as a share of the largest command.
pub(super) const DEAD_ZONE_SHARE: f64 = 0.02;
/// Sizes below which nobody would call it a difference: delay and lag (s), gain, share of the largest
/// command, and sag (1/s).
const TIME_FLOOR_S: f64 = 2e-4;
const GAIN_FLOOR: f64 = 1e-4;
const COMMAND_SHARE: f64 = 2e-4;
const SAG_FLOOR: f64 = 2e-5;
const CLOCK_FLOOR: f64 = 1e-5;

/// What a drive differs by between two recordings without anybody calling it a change (standard
/// deviations): times (s), gains, share of the largest command, sag (1/s), rate of a clock.
const UNNOTICED_S: f64 = 5e-3;
const UNNOTICED_GAIN: f64 = 0.006;
const UNNOTICED_ASYMMETRY: f64 = 0.003;
const UNNOTICED_SHARE: f64 = 0.01;
const UNNOTICED_SAG: f64 = 2e-4;
const UNNOTICED_RATE: f64 = 2e-4;

/// Terms of a drive whose parameters begin at `first`, without effects that are excluded. `top` is the
/// largest command (rad/s).
pub(super) fn terms(first: usize, top_rad_s: f64, excluded: &[String]) -> Vec<Term> {
    let command = COMMAND_SHARE * top_rad_s;
    // effect, name of the term, parameters with their floors
    type Row<'a> = (&'a str, &'static str, &'a [(usize, f64)]);
    let all: [Row<'_>; 8] = [
        ("actuator_delay", DELAY_TERM, &[(DELAY, TIME_FLOOR_S)]),
        ("actuator_lag", LAG_TERM, &[(LAG, TIME_FLOOR_S)]),
        (
            "motor_gain",
            GAIN_TERM,
            &[(GAIN, GAIN_FLOOR), (GAIN_ASYMMETRY, GAIN_FLOOR)],
        ),
        ("command_dead_zone", ZONE_TERM, &[(DEAD_ZONE, command)]),
        (
            "command_saturation",
            SATURATION_TERM,
            &[(SATURATION, command)],
        ),
        ("supply_sag", SAG_TERM, &[(SAG, SAG_FLOOR)]),
        ("clock_drift", CLOCK_TERM, &[(CLOCK, CLOCK_FLOOR)]),
        ("", SLOW_TERM, &[(SLOW_SHARE, 0.01), (SLOW_TIME, 1.0)]),
    ];
    let allowed = all
        .into_iter()
        .filter(|(effect, ..)| !excluded.iter().any(|own| own == effect));
    let mut terms: Vec<Term> = allowed
        .map(|(_, name, parameters)| {
            let shifted: Vec<(usize, f64)> = parameters
                .iter()
                .map(|(index, floor)| (first + index, *floor))
                .collect();
            let caution = if name == CLOCK_TERM {
                RATE_CAUTION
            } else {
                1.0
            };
            let mut term = term(name, &shifted, caution);
            term.positive = [ZONE_TERM, SATURATION_TERM, SAG_TERM].contains(&name);
            term.lasting = [GAIN_TERM, ZONE_TERM, SATURATION_TERM, SAG_TERM].contains(&name);
            term
        })
        .collect();
    if !excluded.iter().any(|own| own == "command_dead_band") {
        let mut band = term(BAND_TERM, &[(first + DEAD_BAND, command)], 1.0);
        band.by_profile = true;
        band.lasting = true;
        terms.push(band);
    }
    terms
}

/// Terms of a drive by itself, or of its changes.
pub(super) fn terms_of(drive: &CommandToWheels, excluded: &[String]) -> Vec<Term> {
    let mut terms = terms(0, drive.largest_rad_s, excluded);
    if drive.before.any() {
        terms.retain(|t| !is_nuisance(t));
        for term in &mut terms {
            term.widen(|index| unnoticed(index, drive.largest_rad_s));
        }
    }
    terms
}

/// Deviation by which a parameter of a drive differs between two recordings of one machine.
pub(super) fn unnoticed(parameter: usize, top_rad_s: f64) -> f64 {
    match parameter {
        DELAY | LAG => UNNOTICED_S,
        GAIN => UNNOTICED_GAIN,
        GAIN_ASYMMETRY => UNNOTICED_ASYMMETRY,
        DEAD_BAND | DEAD_ZONE | SATURATION => UNNOTICED_SHARE * top_rad_s,
        SAG => UNNOTICED_SAG,
        CLOCK => UNNOTICED_RATE,
        _ => 0.0,
    }
}

/// Whether a parameter belongs to the slow response, which is no effect.
pub(crate) fn is_nuisance(term: &Term) -> bool {
    term.name == SLOW_TERM
}
