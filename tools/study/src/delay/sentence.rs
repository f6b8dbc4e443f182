//! What a study says first: what the delay does in the user's case.

use super::grid::GridCell;
use super::point::Point;
use super::study::Study;

impl Study {
    /// The points of the user's case ([`super::Grid::case`]), by their delay.
    pub fn case_points(&self) -> Vec<&Point> {
        self.grid
            .case()
            .map_or_else(Vec::new, |case| self.points_of(&case))
    }

    /// The points that differ from a cell in their delay alone, by their delay.
    pub fn points_of(&self, cell: &GridCell) -> Vec<&Point> {
        let is_own = |point: &&Point| point.cell.at(cell.delay_s) == *cell;
        let mut own: Vec<&Point> = self.points.iter().filter(is_own).collect();
        own.sort_by(|a, b| a.cell.delay_s.total_cmp(&b.cell.delay_s));
        own
    }

    /// The answer in one sentence.
    pub fn sentence(&self) -> String {
        let own = self.case_points();
        let (Some(first), Some(last)) = (own.first(), own.last()) else {
            return "The points of the case that was asked for are not in this part of the study."
                .to_owned();
        };
        let ms = |s: f64| format!("{:.0}", 1e3 * s);
        let cm = |m: f64| format!("{:.1}", 1e2 * m);
        let (a, b) = (first.max_spacing_error_m, last.max_spacing_error_m);
        let does = if b > 1.02 * a {
            format!("grows from {} to {} cm", cm(a), cm(b))
        } else if b < 0.98 * a {
            format!("falls from {} to {} cm", cm(a), cm(b))
        } else {
            format!("stays at {} cm", cm(b))
        };
        let case = last.cell.conditions();
        if last.cell.delay_s == first.cell.delay_s {
            return format!(
                "With {} ms of delay on each link the largest spacing error is {} cm, and the position in use is {} ms old ({case}).",
                ms(last.cell.delay_s),
                cm(b),
                ms(last.age_s)
            );
        }
        format!(
            "From {} to {} ms of delay on each link the largest spacing error {does}, and the position in use is {} to {} ms old ({case}).",
            ms(first.cell.delay_s),
            ms(last.cell.delay_s),
            ms(first.age_s),
            ms(last.age_s)
        )
    }
}

impl GridCell {
    /// All but the delay and the number of robots, in words.
    pub fn conditions(&self) -> String {
        let limit = match self.torque_limit.as_str() {
            "none" => "no torque limit".to_owned(),
            other => format!("torque limit {other}"),
        };
        let mut words = vec![
            self.protocol.clone(),
            format!("k_x = {} s⁻¹", self.k_x),
            limit,
        ];
        if self.jitter_s > 0.0 {
            words.push(format!("jitter {} ms", 1e3 * self.jitter_s));
        }
        if self.loss > 0.0 {
            words.push(format!("loss {} %", 1e2 * self.loss));
        }
        words.join(", ")
    }
}
