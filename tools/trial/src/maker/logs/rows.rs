//! Rows of one stream, as a logger writes them.

/// What the values of a row are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Quantity {
    /// Commands, in two columns.
    Command,
    /// Counters of two wheels.
    Counts,
    /// Angles of two wheels (rad).
    Angles,
    /// Speeds of two wheels (rad/s).
    Speeds,
    /// x, y (m) and yaw (rad).
    Pose,
    /// Yaw rate (rad/s).
    Gyro,
}

/// Rows of one stream.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Rows {
    pub(crate) quantity: Quantity,
    /// Period of the sensor (s).
    pub(crate) period_s: f64,
    pub(crate) rows: Vec<Row>,
}

/// One row.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Row {
    /// Its stamp (s).
    pub(crate) t_s: f64,
    /// When what it says was true (s).
    pub(crate) true_s: f64,
    /// Its values, in the order of the columns.
    pub(crate) values: [f64; 3],
}

impl Rows {
    /// Mean of stamp less true time (s).
    pub(crate) fn lag_s(&self) -> f64 {
        let sum: f64 = self.rows.iter().map(|row| row.t_s - row.true_s).sum();
        sum / self.rows.len().max(1) as f64
    }

    /// Puts every stamp at or behind the one before it.
    pub(crate) fn in_order(&mut self) {
        let mut last = f64::NEG_INFINITY;
        for row in &mut self.rows {
            row.t_s = row.t_s.max(last);
            last = row.t_s;
        }
    }

    /// Changes the stamps (s).
    pub(crate) fn restamp(&mut self, mut stamp_s: impl FnMut(f64) -> f64) {
        for row in &mut self.rows {
            row.t_s = stamp_s(row.t_s);
        }
        self.in_order();
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// 1000 rows at 20 Hz whose first two values are ten times the row's number.
    pub(crate) fn counted(quantity: Quantity) -> Rows {
        let row = |k: usize| Row {
            t_s: k as f64 * 0.05,
            true_s: k as f64 * 0.05,
            values: [10.0 * k as f64, 10.0 * k as f64, 0.0],
        };
        Rows {
            quantity,
            period_s: 0.05,
            rows: (0..1000).map(row).collect(),
        }
    }

    #[test]
    fn stamps_never_fall() {
        let mut rows = counted(Quantity::Pose);
        rows.restamp(|t_s| t_s - 0.2 * (t_s * 50.0).sin());
        assert!(rows.rows.windows(2).all(|two| two[0].t_s <= two[1].t_s));
        let mut late = counted(Quantity::Pose);
        late.restamp(|t_s| t_s + 0.3);
        assert!((late.lag_s() - 0.3).abs() < 1e-9);
    }
}
