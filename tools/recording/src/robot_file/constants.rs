//! Constants in the source of a program, in Java, C, C++, Kotlin or Python: the lengths with which a robot's own program
//! reckons, such as `kTrackwidthMeters` of WPILib or `LR_WHEELS_DISTANCE` of firmware.

use std::collections::BTreeMap;
use std::path::Path;

use slipstream_bus::InputError;

use super::drive::Drive;
use super::parameter_names::{INCH_M, quantity_of};
use super::words::one_line;

/// What to give in place of a file without lengths.
const REMEDY: &str = "give the file with the constants of the drive, a URDF or a robot.toml";
/// Functions of WPILib that convert a length to metres.
const FROM_INCHES: [&str; 2] = ["inchesToMeters", "inches_to_meters"];
const FROM_FEET: [&str; 2] = ["feetToMeters", "feet_to_meters"];
/// Suffixes of numbers in C++ that name a unit (m).
const SUFFIXES: [(&str, f64); 5] = [
    ("_in", INCH_M),
    ("_ft", 12.0 * INCH_M),
    ("_mm", 1e-3),
    ("_cm", 1e-2),
    ("_m", 1.0),
];

/// What the constants of a program say about the drive of its robot.
///
/// # Errors
/// If there is no track and no radius among them, or one in no known unit.
pub(super) fn drive(text: &str, path: &Path) -> Result<Drive, InputError> {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let mut drive = Drive::named(one_line(&name));
    let mut known: BTreeMap<&str, ExpressionValue> = BTreeMap::new();
    for (place, line) in text.lines().enumerate() {
        let Some((name, expression)) = assignment(line) else {
            continue;
        };
        let Some(value) = evaluate(expression, &known) else {
            continue;
        };
        known.insert(name, value);
        // Of a template that is not filled in, all numbers are zero.
        let Some((quantity, unit_m)) = quantity_of(name).filter(|_| value.number != 0.0) else {
            continue;
        };
        let unit_m = if value.is_metric { Some(1.0) } else { unit_m };
        let taken = drive.take(&one_line(name), (quantity, unit_m), value.number);
        taken.map_err(|problem| {
            let problem = format!("{name} {problem}");
            InputError::file(path, problem, "give it in metres").at(place as u64 + 1)
        })?;
    }
    let drive = drive.complete();
    match drive.says_something() {
        true => Ok(drive),
        false => {
            let problem = "has no constant that is a track or a wheel's size";
            Err(InputError::file(path, problem, REMEDY))
        }
    }
}

/// The value of an expression.
#[derive(Debug, Clone, Copy, PartialEq)]
struct ExpressionValue {
    number: f64,
    /// Whether the expression says that it is in metres.
    is_metric: bool,
}

/// Name and expression of a line that gives a constant a value.
fn assignment(line: &str) -> Option<(&str, &str)> {
    let line = line.split("//").next()?.trim();
    if let Some(definition) = line.strip_prefix("#define") {
        let (name, rest) = definition.trim().split_once(char::is_whitespace)?;
        let expression = rest.split("/*").next()?.trim();
        return Some((name, expression));
    }
    let line = line.split('#').next()?.trim();
    let end = line.find(['=', '{'])?;
    let (before, after) = line.split_at(end);
    // Of `val kTrack: Double`, the name.
    let before = before.split(": ").next()?.trim();
    let name = before
        .rsplit(|c: char| !(c.is_alphanumeric() || c == '_'))
        .next()?;
    let expression = after
        .get(1..)?
        .trim()
        .trim_end_matches([';', '}', ','])
        .trim();
    (!name.is_empty() && !expression.starts_with('=')).then_some((name, expression))
}

/// The value of a product or quotient of numbers, known constants and conversions.
fn evaluate(expression: &str, known: &BTreeMap<&str, ExpressionValue>) -> Option<ExpressionValue> {
    let mut value: Option<ExpressionValue> = None;
    let mut divides = false;
    let mut rest = expression.trim();
    while !rest.is_empty() {
        let (factor, later) = factor(rest, known)?;
        value = Some(match value {
            None => factor,
            Some(own) => ExpressionValue {
                number: match divides {
                    true => own.number / factor.number,
                    false => own.number * factor.number,
                },
                is_metric: own.is_metric || factor.is_metric,
            },
        });
        rest = later.trim_start();
        divides = match rest.chars().next() {
            None => break,
            Some('*') => false,
            Some('/') => true,
            Some(_) => return None,
        };
        rest = rest.get(1..)?.trim_start();
    }
    value.filter(|own| own.number.is_finite())
}

/// A number, a constant or a conversion at the beginning of an expression, and what follows it.
fn factor<'a>(
    text: &'a str,
    known: &BTreeMap<&str, ExpressionValue>,
) -> Option<(ExpressionValue, &'a str)> {
    let is_of_word = |c: char| c.is_alphanumeric() || matches!(c, '_' | '.');
    let end = text.find(|c: char| !is_of_word(c)).unwrap_or(text.len());
    let (word, rest) = text.split_at(end);
    if let Some(inner) = rest.strip_prefix('(') {
        let (inside, later) = inner.split_once(')')?;
        let own = word.rsplit('.').next()?;
        let unit_m = match own {
            _ if FROM_INCHES.contains(&own) => INCH_M,
            _ if FROM_FEET.contains(&own) => 12.0 * INCH_M,
            _ => return None,
        };
        let inside = evaluate(inside, known)?;
        let number = inside.number * unit_m;
        return Some((
            ExpressionValue {
                number,
                is_metric: true,
            },
            later,
        ));
    }
    let (number, unit_m) = number(word).or_else(|| {
        let name = word.rsplit('.').next()?;
        let own = known.get(name)?;
        Some((own.number, own.is_metric.then_some(1.0)))
    })?;
    let value = ExpressionValue {
        number: number * unit_m.unwrap_or(1.0),
        is_metric: unit_m.is_some(),
    };
    Some((value, rest))
}

/// A number, and the unit that its suffix names (m).
fn number(word: &str) -> Option<(f64, Option<f64>)> {
    if let Some((suffix, unit_m)) = SUFFIXES.iter().find(|(own, _)| word.ends_with(own))
        && let Ok(number) = word.trim_end_matches(suffix).parse()
    {
        return Some((number, Some(*unit_m)));
    }
    let plain = word.trim_end_matches(['f', 'F', 'd', 'D', 'L']);
    plain.parse().ok().map(|number| (number, None))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lengths(text: &str) -> [Option<f64>; 2] {
        let drive = drive(text, Path::new("Constants.java")).unwrap();
        let round = |own: f64| (own * 1e9).round() / 1e9;
        [drive.half_track(), drive.radius].map(|own| own.map(|own| round(own.value_m)))
    }

    #[test]
    fn constants_of_programs_are_read_in_their_units() {
        let java = "package frc.robot;\npublic final class DriveConstants {\n  public static final double kTrackwidthMeters = 0.69; // m\n\
                    public static final double kWheelDiameterMeters = Units.inchesToMeters(6);\n}";
        assert_eq!(lengths(java), [Some(0.345), Some(0.0762)]);
        let c = "#define COUNTS_PER_REV 2280\n#define WHEEL_DIAMETER 0.152  // m\n#define LR_WHEELS_DISTANCE 0.271 /* m */\n";
        assert_eq!(lengths(c), [Some(0.1355), Some(0.076)]);
        let cpp = "constexpr auto kTrackwidth = 27_in;\nconstexpr units::meter_t kWheelRadius{7.62_cm};\n";
        assert_eq!(lengths(cpp), [Some(0.3429), Some(0.0762)]);
        let python =
            "# drive\nINCH = 0.0254\nTRACK_WIDTH = 20 * INCH\nkWheelRadiusInches: float = 3\n";
        assert_eq!(lengths(python), [Some(0.254), Some(0.0762)]);
        let kotlin =
            "const val wheelBase = 0.5\nconst val wheelRadius = WHEEL / 2\nval wheelDiameter = 0.2";
        assert_eq!(lengths(kotlin), [Some(0.25), Some(0.1)]);
    }

    #[test]
    fn what_is_no_length_is_refused() {
        let of = |text: &str| drive(text, Path::new("c.h")).unwrap_err().to_string();
        assert!(of("int x = 1;").contains("c.h: has no constant that is a track"));
        assert!(of("double kTrackWidth = 0;").contains("has no constant"));
        assert!(
            of("int y;\ndouble track_width = 16;")
                .starts_with("c.h:2: track_width is 16, which no robot has")
        );
    }
}
