//! Moments as text says them: a number, a date with a time, a time of day.

/// A moment as text says it: whole units and the rest, so that times since 1970 keep every digit.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Moment {
    pub(super) whole: i64,
    pub(super) rest: f64,
}

impl Moment {
    /// The time since another moment, in the unit of the text.
    pub(super) fn since(self, other: Self) -> f64 {
        (self.whole.saturating_sub(other.whole)) as f64 + (self.rest - other.rest)
    }

    /// The earlier of two moments.
    pub(super) fn earlier(self, other: Self) -> Self {
        if other.since(self) < 0.0 { other } else { self }
    }

    /// A number.
    pub(super) fn parse(text: &str) -> Option<Self> {
        let is_plain = |c: char| c.is_ascii_digit() || c == '.' || c == '-' || c == '+';
        let whole = text.split('.').next().unwrap_or_default();
        if !text.chars().all(is_plain) || whole.starts_with('-') || whole.is_empty() {
            let number: f64 = text.parse().ok()?;
            let fits = number.is_finite() && number.abs() < 9e15;
            let moment = || Self {
                whole: number.floor() as i64,
                rest: number - number.floor(),
            };
            return fits.then(moment);
        }
        let rest = text.get(whole.len()..).unwrap_or_default();
        Some(Self {
            whole: whole.parse().ok()?,
            rest: match rest {
                "" | "." => 0.0,
                rest => rest.parse().ok()?,
            },
        })
    }

    /// A date with a time, such as `2024-05-01T12:00:00.25+02:00`, as seconds since 1970. Without a zone it is taken
    /// for UTC: all times of a recording are of one clock.
    pub(super) fn parse_date(text: &str) -> Option<Self> {
        let date = text.get(..10)?;
        let time = text.get(10..)?.strip_prefix([' ', 'T', 't', '_', '/'])?;
        let mut parts = date.split(['-', '/']);
        let [year, month, day] = [4, 2, 2].map(|digits| whole(parts.next(), digits));
        let days = days_since_1970(year?, month?, day?)?;
        let (time, zone_s) = split_zone(time.trim())?;
        let of_day = Self::parse_time_of_day(time)?;
        Some(Self {
            whole: days * DAY_S + of_day.whole - zone_s,
            ..of_day
        })
    }

    /// A time of day, such as `12:00:00.25`, as seconds since midnight.
    pub(super) fn parse_time_of_day(text: &str) -> Option<Self> {
        let (clock, fraction) = match text.split_once(['.', ',']) {
            None => (text, "0"),
            Some((clock, fraction)) => (clock, fraction),
        };
        let is_fraction = fraction.bytes().all(|byte| byte.is_ascii_digit());
        let mut parts = clock.split(':');
        let [hours, minutes, seconds] = [2, 2, 2].map(|digits| whole(parts.next(), digits));
        let (hours, minutes, seconds) = (hours?, minutes?, seconds?);
        let exists = hours < 24 && minutes < 60 && seconds <= 60 && parts.next().is_none();
        (is_fraction && exists).then_some(Self {
            whole: hours * 3600 + minutes * 60 + seconds,
            rest: format!("0.{fraction}").parse().ok()?,
        })
    }
}

/// Length of a day (s).
pub(super) const DAY_S: i64 = 86_400;

/// A whole number of so many digits; of two, one may be missing.
fn whole(text: Option<&str>, digits: usize) -> Option<i64> {
    let text = text?;
    let is_whole = text.bytes().all(|byte| byte.is_ascii_digit());
    let fits = text.len() == digits || (digits == 2 && text.len() == 1);
    (is_whole && fits).then(|| text.parse().ok()).flatten()
}

/// The days from 1970-01-01 to a date; `None` if there is no such date. Years begin in March here, so that the day that
/// some years have more is their last one.
fn days_since_1970(year: i64, month: i64, day: i64) -> Option<i64> {
    if !(1..=12).contains(&month) || !(1..=31).contains(&day) {
        return None;
    }
    let years = if month > 2 { year } else { year - 1 };
    let months = (month + 9) % 12;
    let leap_days = years / 4 - years / 100 + years / 400;
    Some(years * 365 + leap_days + (months * 153 + 2) / 5 + day - 719_469)
}

/// A time without its zone, and the zone's offset from UTC (s).
fn split_zone(time: &str) -> Option<(&str, i64)> {
    if let Some(time) = time.strip_suffix(['Z', 'z']) {
        return Some((time, 0));
    }
    let Some(place) = time.find(['+', '-']) else {
        return Some((time, 0));
    };
    let (time, zone) = time.split_at_checked(place)?;
    let sign = if zone.starts_with('-') { -1 } else { 1 };
    let zone = zone.get(1..)?.replace(':', "");
    let hours = whole(zone.get(..2), 2)?;
    let minutes = match zone.get(2..) {
        None | Some("") => 0,
        minutes => whole(minutes, 2)?,
    };
    Some((time.trim_end(), sign * (hours * 3600 + minutes * 60)))
}

/// A number with a decimal comma, with a point in its place.
pub(super) fn with_point(text: &str) -> String {
    let is_one = !text.contains('.') && text.matches(',').count() == 1;
    if is_one {
        text.replace(',', ".")
    } else {
        text.to_owned()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_since_1970_keep_their_digits() {
        let moment = |text| Moment::parse(text).unwrap();
        let start = moment("1700000000.000000001");
        assert_eq!(moment("1700000001.000000002").since(start), 1.0 + 1e-9);
        assert_eq!(
            moment("1700000000000123456").since(moment("1700000000000000000")),
            123_456.0
        );
        assert_eq!(moment("-0.5").since(moment("1e0")), -1.5);
        assert_eq!(Moment::parse("12:30"), None);
        assert_eq!(Moment::parse("inf"), None);
    }

    #[test]
    fn dates_are_seconds_since_1970() {
        let cases = [
            ("1970-01-01 00:00:00", 0),
            ("2000-03-01T00:00:00Z", 951_868_800),
            ("2024-02-29T23:59:59+00:00", 1_709_251_199),
            ("2023-11-14 22:13:20.5", 1_700_000_000),
            ("2023-11-15T00:13:20.5+02:00", 1_700_000_000),
            ("2023-11-14T17:13:20-0500", 1_700_000_000),
            ("2023/11/14/22:13:20", 1_700_000_000),
        ];
        for (text, whole) in cases {
            assert_eq!(
                Moment::parse_date(text).map(|m| m.whole),
                Some(whole),
                "{text}"
            );
        }
        let fraction = Moment::parse_date("2023-11-14 22:13:20.000001").unwrap();
        assert_eq!(fraction.rest, 1e-6);
        for text in [
            "2023-13-14 22:13:20",
            "2023-11-14",
            "2023-11-14 25:13:20",
            "1700000000.5",
            "2023-11-14 22:13:20+ä",
        ] {
            assert_eq!(Moment::parse_date(text), None, "{text}");
        }
        let of_day = Moment::parse_time_of_day("01:02:03,25").unwrap();
        assert_eq!((of_day.whole, of_day.rest), (3723, 0.25));
    }
}
