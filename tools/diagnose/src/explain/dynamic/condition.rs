//! Under which condition an effect is at work.

use slipstream_bus::RobotModel;
use slipstream_sim::breakaway_nm;
use slipstream_sim::effects::When;

use crate::model::hypothesis::{Hypothesis, STATIC, is_direction};

/// Under which condition an effect is at work, for a person.
pub(crate) fn condition(model: &RobotModel, own: &Hypothesis) -> String {
    let value = |name: &str| own.value(name).unwrap_or(0.0);
    let direction = own.values.iter().find(|v| is_direction(own.info, v.0));
    match own.info.acts {
        When::Sliding => match breakaway_nm(model, value(STATIC)) {
            Some(torque) => format!("drive torque of both wheels above {torque:.3} N m"),
            None => own.info.condition.to_owned(),
        },
        When::Inside => format!(
            "a wheel within {:.2} m of ({:.2}, {:.2}) m",
            value("radius_m"),
            value("x_m"),
            value("y_m")
        ),
        When::Once => format!("at {:.2} s", value("t_s")),
        _ => match direction {
            Some((_, down)) => format!("downhill towards {:.0} degrees", down.to_degrees()),
            None => own.info.condition.to_owned(),
        },
    }
}
