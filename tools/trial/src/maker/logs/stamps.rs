//! What loggers do to stamps and rows. `size` runs from 0 to 1.

use super::rows::Rows;
use crate::maker::random::RandomStream;

/// A number between two ends, on a logarithmic scale.
pub(crate) fn within([from, to]: [f64; 2], size: f64) -> f64 {
    from * (to / from).powf(size)
}

/// Stamps scatter about the true time by 2 to 30 % of the period.
pub(super) fn jitter(rows: &mut Rows, size: f64, random: &mut RandomStream) -> bool {
    let deviation_s = rows.period_s * within([0.02, 0.3], size);
    rows.restamp(|t_s| t_s + random.normal(deviation_s));
    true
}

/// A logger that polls: stamp less true time rises by up to 0.2 to 1.5 periods, and drops.
pub(super) fn saw_tooth(rows: &mut Rows, size: f64, random: &mut RandomStream) -> bool {
    let most_s = rows.period_s * within([0.2, 1.5], size);
    let tooth_s = rows.period_s * random.log_uniform(5.0, 50.0);
    let phase = random.unit();
    rows.restamp(|t_s| t_s + most_s * (t_s / tooth_s + phase).fract());
    true
}

/// 2 to 25 % of the rows repeat the value of the row before.
pub(super) fn held(rows: &mut Rows, size: f64, random: &mut RandomStream) -> bool {
    let share = within([0.02, 0.25], size);
    for k in 1..rows.rows.len() {
        if random.bernoulli(share) {
            let before = rows.rows[k - 1];
            rows.rows[k].values = before.values;
            rows.rows[k].true_s = before.true_s;
        }
    }
    true
}

/// 1 to 15 % of the rows are there twice.
pub(super) fn doubled(rows: &mut Rows, size: f64, random: &mut RandomStream) -> bool {
    let share = within([0.01, 0.15], size);
    let twice = rows.rows.iter().flat_map(|row| {
        let times = 1 + usize::from(random.bernoulli(share));
        std::iter::repeat_n(*row, times)
    });
    rows.rows = twice.collect();
    true
}

/// 1 to 15 % of the rows are lost.
pub(super) fn dropped(rows: &mut Rows, size: f64, random: &mut RandomStream) -> bool {
    let share = within([0.01, 0.15], size);
    rows.rows.retain(|_| !random.bernoulli(share));
    true
}

/// Gaps of 0.2 to 1.5 s, two to eight a minute; their rows come at once when they end.
pub(super) fn bursts(rows: &mut Rows, size: f64, random: &mut RandomStream) -> bool {
    let Some(first) = rows.rows.first() else {
        return false;
    };
    let between_s = 60.0 / within([2.0, 8.0], size);
    let mut draw = |from_s: f64| {
        let begin = from_s + between_s * random.uniform(0.3, 1.7);
        [begin, begin + random.log_uniform(0.2, 1.5)]
    };
    let mut gap = draw(first.t_s);
    let mut waiting = 0.0;
    for row in &mut rows.rows {
        if row.t_s > gap[1] {
            gap = draw(gap[1]);
            waiting = 0.0;
        }
        if row.t_s > gap[0] {
            waiting += 1.0;
            row.t_s = row.t_s.max(gap[1] + 1e-4 * waiting);
        }
    }
    rows.in_order();
    true
}

#[cfg(test)]
mod tests {
    use super::super::rows::tests::counted;
    use super::super::rows::{Quantity, Rows};
    use super::*;

    fn changed(apply: fn(&mut Rows, f64, &mut RandomStream) -> bool, size: f64) -> Rows {
        let mut rows = counted(Quantity::Pose);
        assert!(apply(&mut rows, size, &mut RandomStream::new(3, 0)));
        assert!(rows.rows.windows(2).all(|two| two[0].t_s <= two[1].t_s));
        rows
    }

    fn lags(rows: &Rows) -> Vec<f64> {
        rows.rows.iter().map(|row| row.t_s - row.true_s).collect()
    }

    #[test]
    fn jitter_scatters_about_the_true_time() {
        let rows = changed(jitter, 1.0);
        let square: f64 = lags(&rows).iter().map(|lag| lag * lag).sum();
        // 1000 rows of 15 ms
        assert!(((square / 1000.0).sqrt() / 0.015 - 1.0).abs() < 0.1);
        assert!(rows.lag_s().abs() < 0.002);
    }

    #[test]
    fn a_saw_tooth_rises_and_drops() {
        let lags = lags(&changed(saw_tooth, 1.0));
        let most = lags.iter().copied().fold(0.0, f64::max);
        assert!(lags.iter().all(|lag| *lag > -1e-9) && most > 0.06 && most < 0.0751);
        let rising = lags.windows(2).filter(|two| two[1] > two[0]).count();
        assert!(rising > 700 && rising < 995, "{rising}");
    }

    #[test]
    fn held_rows_repeat_the_value_before() {
        let rows = changed(held, 1.0);
        let again = rows
            .rows
            .windows(2)
            .filter(|two| two[0].values == two[1].values);
        // 250 of 1000 are expected, with a deviation of 14
        assert!((190..310).contains(&again.count()));
        assert!(rows.lag_s() > 0.01);
    }

    #[test]
    fn doubled_and_dropped_rows_are_counted() {
        let (more, less) = (
            changed(doubled, 1.0).rows.len(),
            changed(dropped, 1.0).rows.len(),
        );
        // 150 of 1000, deviation 11
        assert!(
            (1100..1200).contains(&more) && (800..900).contains(&less),
            "{more} {less}"
        );
    }

    #[test]
    fn rows_of_a_gap_come_at_once() {
        let rows = changed(bursts, 1.0);
        let gaps = rows
            .rows
            .windows(2)
            .filter(|two| two[1].t_s - two[0].t_s > 0.19);
        let dense = rows
            .rows
            .windows(2)
            .filter(|two| two[1].t_s - two[0].t_s < 2e-4);
        assert!((3..=9).contains(&gaps.count()) && dense.count() > 10);
        let late = lags(&rows).into_iter().filter(|lag| *lag > 1e-9).count();
        assert!(late > 10 && late < 400, "{late}");
    }
}
