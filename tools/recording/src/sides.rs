//! The side of a robot that a name tells, such as `front_left_wheel` or `/rwheel`.

/// A side of a robot. As an index: right 0, left 1, as in all pairs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Side {
    Right,
    Left,
}

impl Side {
    /// Right and left.
    pub(crate) const BOTH: [Self; 2] = [Self::Right, Self::Left];

    /// Its word.
    pub(crate) fn word(self) -> &'static str {
        match self {
            Self::Right => "right",
            Self::Left => "left",
        }
    }

    /// Words of a few letters that mean it: alone, beside the letter of front, middle or rear, or before a wheel or motor.
    fn short(self) -> [&'static str; 12] {
        match self {
            Self::Right => [
                "r", "fr", "rf", "rr", "br", "rb", "mr", "rm", "cr", "rwheel", "wheelr", "rmotor",
            ],
            Self::Left => [
                "l", "fl", "lf", "rl", "lr", "bl", "lb", "ml", "lm", "lwheel", "wheell", "lmotor",
            ],
        }
    }

    /// Whether a name in small letters has a word of it.
    fn is_in(self, name: &str) -> bool {
        name.contains(self.word()) || words(name).any(|word| self.short().contains(&word))
    }
}

/// The side that a name tells; `None` if it tells none or both.
pub(crate) fn side_of(name: &str) -> Option<Side> {
    let name = split_humps(name);
    // A whole word outweighs letters: of `left_r_wheel`, left.
    let by_word = Side::BOTH.map(|side| name.contains(side.word()));
    let tells = match by_word {
        [false, false] => Side::BOTH.map(|side| side.is_in(&name)),
        _ => by_word,
    };
    match tells {
        [true, false] => Some(Side::Right),
        [false, true] => Some(Side::Left),
        _ => None,
    }
}

/// The side that a name tells, and the name in small letters with a mark where it tells it: `*_ticks` of `left_ticks`, and of
/// `right_ticks`. Names of one pair have the same rest.
pub(crate) fn side_and_rest(name: &str) -> Option<(Side, String)> {
    let side = side_of(name)?;
    let name = split_humps(name);
    if name.contains(side.word()) {
        return Some((side, name.replace(side.word(), "*")));
    }
    let mut rest = String::with_capacity(name.len());
    let mut unread = name.as_str();
    while !unread.is_empty() {
        let is_letter = |c: char| c.is_ascii_alphabetic();
        let end = unread.find(|c| !is_letter(c)).unwrap_or(unread.len());
        let (word, others) = unread.split_at(end);
        let is_side = side.short().contains(&word);
        // `fr` and `fl` leave `f`, `rr` and `rl` leave `r`.
        let left = match is_side {
            true if word.contains("wheel") => "*wheel".to_owned(),
            true if word.contains("motor") => "*motor".to_owned(),
            true => format!("*{}", word.replacen(&side.word()[..1], "", 1)),
            false => word.to_owned(),
        };
        rest.push_str(&left);
        let start = others.find(is_letter).unwrap_or(others.len());
        let (between, others) = others.split_at(start);
        rest.push_str(between);
        unread = others;
    }
    Some((side, rest))
}

/// The words of letters in a name in any spelling, in small letters: `left`, `wheel` and `ticks` of `leftWheelTicks2`.
pub(crate) fn words_of(name: &str) -> Vec<String> {
    words(&split_humps(name)).map(str::to_owned).collect()
}

/// The words of letters in a name, such as `front`, `left` and `wheel` of `front_left_wheel_2`.
pub(crate) fn words(name: &str) -> impl Iterator<Item = &str> {
    name.split(|c: char| !c.is_ascii_alphabetic())
        .filter(|word| !word.is_empty())
}

/// A name in small letters, with its words apart where only a capital tells them: `wheelR` becomes `wheel_r`.
pub(crate) fn split_humps(name: &str) -> String {
    let mut split = String::with_capacity(name.len());
    let mut before = ' ';
    for letter in name.chars() {
        if letter.is_uppercase() && before.is_lowercase() {
            split.push('_');
        }
        before = letter;
        split.extend(letter.to_lowercase());
    }
    split
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_tell_sides() {
        let (right, left) = (Some(Side::Right), Some(Side::Left));
        let cases = [
            ("left_wheel_joint", left),
            ("wheel_right", right),
            ("lf_wheel", left),
            ("rr", right),
            ("rl_joint", left),
            ("wheel_fr_joint", right),
            ("wheelR", right),
            ("frontLeftWheel", left),
            ("/rwheel", right),
            ("/wheel_r2/ticks", right),
            ("left_r_wheel", left),
            ("drive_1", None),
            ("upright_left", None),
            ("arm", None),
        ];
        for (name, side) in cases {
            assert_eq!(side_of(name), side, "{name}");
        }
    }

    #[test]
    fn the_names_of_a_pair_have_one_rest() {
        let pairs = [
            ("/left_ticks", "/right_ticks", "/*_ticks"),
            ("leftTicks", "rightTicks", "*_ticks"),
            ("/lwheel", "/rwheel", "/*wheel"),
            ("enc_fl2", "enc_fr2", "enc_*f2"),
            ("wheel_rl", "wheel_rr", "wheel_*r"),
            ("/m/l.data", "/m/r.data", "/m/*.data"),
        ];
        for (left, right, rest) in pairs {
            let rest = rest.to_owned();
            assert_eq!(side_and_rest(left), Some((Side::Left, rest.clone())));
            assert_eq!(side_and_rest(right), Some((Side::Right, rest)));
        }
        assert_eq!(side_and_rest("/ticks"), None);
    }
}
