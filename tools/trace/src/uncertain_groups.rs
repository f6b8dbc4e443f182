//! Percentiles of groups of durations that are uncertain by the clocks of two hosts.

use std::collections::BTreeMap;

use slipstream_recording::Disk;

use crate::percentiles::Percentiles;
use crate::pile::Groups;
use crate::uncertainty::Uncertainty;

/// Of each group the number of durations, their percentiles, and by how much the median can be wrong.
pub(crate) type UncertainPercentiles<G> = BTreeMap<G, (u64, Percentiles, Uncertainty)>;

/// Durations in groups, each with its uncertainty.
#[derive(Debug)]
pub(crate) struct UncertainGroups<G> {
    durations: Groups<G>,
    /// The smallest and the largest that each duration can be, of groups that are not exact.
    ends: [Groups<G>; 2],
    /// The worst uncertainty of a duration of each group.
    worst: BTreeMap<G, Uncertainty>,
}

impl<G: Ord + Copy> UncertainGroups<G> {
    /// No durations yet.
    pub(crate) fn new(disk: &Disk) -> Self {
        Self {
            durations: Groups::new(disk),
            ends: [(); 2].map(|()| Groups::new(disk)),
            worst: BTreeMap::new(),
        }
    }

    /// Adds a duration (ns) to a group.
    pub(crate) fn push(&mut self, group: G, duration_ns: i64, uncertainty: Uncertainty) {
        self.durations.push(group, duration_ns);
        let worst = self.worst.entry(group).or_default();
        *worst = uncertainty.max(*worst);
        if let Uncertainty::Within(ns) = uncertainty {
            let [least, most] = &mut self.ends;
            least.push(group, duration_ns.saturating_sub(ns));
            most.push(group, duration_ns.saturating_add(ns));
        }
    }

    /// The percentiles of each group. If every duration were as small as it can be, the median would be the least one
    /// possible, and so for the largest: the true median lies between them.
    pub(crate) fn percentiles(&self) -> UncertainPercentiles<G> {
        let ends = self.ends.each_ref().map(Groups::percentiles);
        let group = |(group, (count, figures)): (G, (u64, Percentiles))| {
            let worst = self.worst.get(&group).copied().unwrap_or_default();
            let distances_ns = ends.each_ref().map(|end| {
                let (_, end) = end.get(&group)?;
                Some(((end.p50_s - figures.p50_s).abs() * 1e9).round() as i64)
            });
            let uncertainty = match (worst, distances_ns) {
                (Uncertainty::Within(_), [Some(down_ns), Some(up_ns)]) => {
                    Uncertainty::Within(down_ns.max(up_ns))
                }
                (worst, _) => worst,
            };
            (group, (count, figures, uncertainty))
        };
        self.durations
            .percentiles()
            .into_iter()
            .map(group)
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_bad_duration_does_not_make_the_median_bad() {
        let mut groups = UncertainGroups::new(&Disk::default());
        for (duration_ns, ns) in [(100, 5), (110, 6), (120, 7), (130, 8), (9000, 8000)] {
            groups.push(1, duration_ns, Uncertainty::Within(ns));
        }
        groups.push(2, 7, Uncertainty::Exact);
        groups.push(3, 7, Uncertainty::Within(4));
        groups.push(3, 8, Uncertainty::Unknown);
        let found = groups.percentiles();
        assert_eq!((found[&1].0, found[&1].1.p50_s), (5, 120e-9));
        assert_eq!(
            [1, 2, 3].map(|group| found[&group].2),
            [
                Uncertainty::Within(7),
                Uncertainty::Exact,
                Uncertainty::Unknown
            ]
        );
    }
}
