//! In which unit a length is given: metres, unless its name says another or no robot is so large.

use super::parameter_names::Quantity;

/// Larger distances of wheels are none in metres.
const LARGEST_SEPARATION: f64 = 10.0;
/// Larger radii are none in metres.
const LARGEST_RADIUS: f64 = 3.0;
/// From here on, distances that are none in metres are millimetres. Smaller ones could be centimetres or inches.
const SEPARATION_MM: f64 = 50.0;
/// From here on, radii that are none in metres are millimetres.
const RADIUS_MM: f64 = 10.0;

/// A length in metres, and whether its unit was guessed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct InMetres {
    pub(super) value_m: f64,
    pub(super) is_from_mm: bool,
}

/// A length as it is written, in metres. `unit_m` is what its name says.
///
/// # Errors
/// If it is too large for metres and too small for millimetres.
pub(super) fn in_metres(
    value: f64,
    quantity: Quantity,
    unit_m: Option<f64>,
) -> Result<InMetres, String> {
    let known = |value_m: f64| InMetres {
        value_m,
        is_from_mm: false,
    };
    if let Some(unit_m) = unit_m {
        return Ok(known(value * unit_m));
    }
    let (largest, from_mm) = match quantity {
        Quantity::Radius => (LARGEST_RADIUS, RADIUS_MM),
        Quantity::Diameter => (2.0 * LARGEST_RADIUS, 2.0 * RADIUS_MM),
        _ => (LARGEST_SEPARATION, SEPARATION_MM),
    };
    if value <= largest {
        Ok(known(value))
    } else if value < from_mm {
        Err(format!("is {value}, which no robot has in metres"))
    } else {
        Ok(InMetres {
            value_m: value / 1000.0,
            is_from_mm: true,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_no_robot_has_in_metres_is_in_millimetres_or_unclear() {
        let of = |value, quantity| in_metres(value, quantity, None).map(|own| own.value_m);
        assert_eq!(of(0.3, Quantity::Separation), Ok(0.3));
        assert_eq!(of(300.0, Quantity::Separation), Ok(0.3));
        assert_eq!(of(50.0, Quantity::Radius), Ok(0.05));
        assert!(of(16.0, Quantity::Separation).is_err());
        let said = in_metres(6.0, Quantity::Diameter, Some(0.0254));
        assert_eq!(said.map(|own| own.value_m), Ok(6.0 * 0.0254));
    }
}
