//! What a law looks like: the nearest of the shapes that have a name.

/// Share of its square sum that a shape explains of a law that resembles it.
const RESEMBLES: f64 = 0.9;

/// A shape over a driver, whose largest size is 1.
struct Shape {
    /// What it is, where its factor is negative and where it is positive.
    names: [&'static str; 2],
    /// Whether only a turn rate has it.
    of_turns: bool,
    value: fn(x: f64, corner: f64) -> f64,
}

const SHAPES: [Shape; 6] = [
    Shape {
        names: [
            "a constant size against it, as Coulomb friction",
            "a constant size along it",
        ],
        of_turns: false,
        value: |x, _| if x == 0.0 { 0.0 } else { x.signum() },
    },
    Shape {
        names: [
            "in proportion against it, as viscous friction",
            "in proportion to it",
        ],
        of_turns: false,
        value: |x, _| x,
    },
    Shape {
        names: [
            "with its square against it, as drag",
            "with its square along it",
        ],
        of_turns: false,
        value: |x, _| x * x.abs(),
    },
    Shape {
        names: ["a loss in turns, either way", "a gain in turns, either way"],
        of_turns: true,
        value: |x, _| x.abs(),
    },
    Shape {
        names: [
            "against it up to a size and constant beyond, as a dead zone",
            "along it up to a size and constant beyond",
        ],
        of_turns: false,
        value: |x, corner| x.clamp(-corner, corner),
    },
    Shape {
        names: [
            "nothing up to a size and a loss beyond, as saturation",
            "nothing up to a size and a gain beyond",
        ],
        of_turns: false,
        value: |x, corner| x - x.clamp(-corner, corner),
    },
];

/// What a law over `driver` with `values` at `knots` resembles; `None` where no shape is near.
pub fn resemblance(driver: &str, knots: &[f64], values: &[f64]) -> Option<&'static str> {
    let reach = knots.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
    let square: f64 = values.iter().map(|v| v * v).sum();
    let two = knots.iter().filter(|x| **x != 0.0).count() >= 2;
    if !["v", "w"].contains(&driver) || reach <= 0.0 || square <= 0.0 || !two {
        return None;
    }
    let corners: Vec<f64> = knots
        .iter()
        .map(|x| x.abs() / reach)
        .filter(|x| *x > 0.0 && *x < 1.0)
        .collect();
    let mut best: Option<(f64, &'static str)> = None;
    for shape in SHAPES.iter().filter(|own| !own.of_turns || driver == "w") {
        for corner in corners.iter().copied().chain([1.0]) {
            let parts = || {
                let shapes = knots.iter().map(|x| (shape.value)(x / reach, corner));
                shapes.zip(values)
            };
            let own: f64 = parts().map(|(f, _)| f * f).sum();
            let both: f64 = parts().map(|(f, v)| f * v).sum();
            if own <= 0.0 {
                continue;
            }
            let explained = both * both / (own * square);
            // a shape with a corner has to be clearly nearer than one without
            if best.is_none_or(|(most, _)| explained > most + 1e-3) {
                best = Some((explained, shape.names[usize::from(both > 0.0)]));
            }
        }
    }
    best.filter(|(explained, _)| *explained > RESEMBLES)
        .map(|(_, name)| name)
}

#[cfg(test)]
mod tests {
    use super::*;

    const KNOTS: [f64; 7] = [-3.0, -2.0, -1.0, 0.0, 1.0, 2.0, 3.0];

    fn named(driver: &str, law: fn(f64) -> f64) -> Option<&'static str> {
        resemblance(driver, &KNOTS, &KNOTS.map(law))
    }

    #[test]
    fn shapes_have_their_names() {
        let coulomb = |x: f64| if x == 0.0 { 0.0 } else { -0.2 * x.signum() };
        for (driver, law, word) in [
            ("v", coulomb as fn(f64) -> f64, "Coulomb"),
            ("v", |x| -0.1 * x, "viscous"),
            ("v", |x| -0.1 * x * x.abs(), "square"),
            ("w", |x| -0.05 * x.abs(), "loss in turns"),
            ("v", |x| -0.1 * x.clamp(-2.0, 2.0), "dead zone"),
            ("v", |x| -0.1 * (x - x.clamp(-2.0, 2.0)), "saturation"),
        ] {
            let name = named(driver, law).unwrap_or("nothing");
            assert!(name.contains(word), "{word}: {name}");
        }
    }

    #[test]
    fn a_law_like_no_shape_has_no_name() {
        assert_eq!(named("v", |x| (2.5 * x).cos()), None);
        assert_eq!(named("heading", |x| x), None);
    }
}
