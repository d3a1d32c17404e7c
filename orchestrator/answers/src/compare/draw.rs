//! Sampling of the rows of a table, as far as known: the basis of the intervals.
//!
//! Rows of one point of a design (values of `[[vary]]`) depend on one another. The independent units are then the sums over points
//! (a ratio of sums over points, W. G. Cochran, "Sampling techniques" (1977), section 2.11).

use crate::estimate::scheme::Scheme;

/// Sampling of the rows of a table.
#[derive(Debug, Clone, PartialEq)]
pub struct Draw {
    scheme: Scheme,
    rows_per_point: u64,
    replicate: Vec<u32>,
}

/// Groups of dependent rows, by their indices in a list.
#[derive(Debug, Clone)]
pub(super) struct Clusters {
    pub scheme: Scheme,
    /// Cluster of each row; empty where every row is independent.
    pub of: Vec<u32>,
    /// Whether clusters are points; only points with a value count.
    are_points: bool,
}

impl Draw {
    /// Sampling of a whole study: scheme of its design, rows of a point, and the replicate of each point.
    #[must_use]
    pub fn whole(scheme: Scheme, rows_per_point: u64, replicate: Vec<u32>) -> Self {
        Self { scheme, rows_per_point: rows_per_point.max(1), replicate }
    }

    /// Rows that allow no interval, and the reason.
    #[must_use]
    pub fn without(why: &str) -> Self {
        Self::whole(Scheme::Without(why.to_owned()), 1, Vec::new())
    }

    /// The clusters of these samples.
    pub(super) fn clusters(&self, samples: impl Iterator<Item = u64>) -> Clusters {
        let points = self.replicate.len() as u64;
        let alone = |scheme: &Scheme| Clusters { scheme: scheme.clone(), of: Vec::new(), are_points: false };
        let strange = || alone(&Scheme::Without("no interval: a sample does not belong to its study".to_owned()));
        match &self.scheme {
            Scheme::Without(_) => alone(&self.scheme),
            Scheme::Independent if self.rows_per_point == 1 => alone(&self.scheme),
            Scheme::Independent => {
                let point = |sample: u64| Some(sample / self.rows_per_point).filter(|point| *point < points);
                let of: Option<Vec<u32>> = samples.map(|sample| point(sample).map(|point| point as u32)).collect();
                let scheme = Scheme::Replicated(self.replicate.len());
                of.map_or_else(strange, |of| Clusters { scheme, of, are_points: true })
            }
            Scheme::Replicated(_) => {
                let replicate = |sample: u64| {
                    let point = usize::try_from(sample / self.rows_per_point).ok()?;
                    self.replicate.get(point).copied()
                };
                let of: Option<Vec<u32>> = samples.map(replicate).collect();
                of.map_or_else(strange, |of| Clusters { scheme: self.scheme.clone(), of, are_points: false })
            }
        }
    }
}

impl Clusters {
    /// Cluster of the n-th row.
    pub fn cluster(&self, at: usize) -> u32 {
        self.of.get(at).copied().unwrap_or(0)
    }

    /// Scheme for the rows that have a value; `clusters` are theirs and are renumbered. Points without a value do not count.
    pub fn narrowed(&self, clusters: &mut [u32]) -> Scheme {
        if !self.are_points {
            return self.scheme.clone();
        }
        let mut number = vec![u32::MAX; clusters.iter().max().map_or(0, |last| *last as usize + 1)];
        let mut count = 0;
        for cluster in clusters {
            let found = &mut number[*cluster as usize];
            if *found == u32::MAX {
                *found = count;
                count += 1;
            }
            *cluster = *found;
        }
        Scheme::Replicated(count as usize)
    }

    /// Whether clusters of equal number correspond in both tables: points, or equally many replicates.
    pub fn are_alike(&self, other: &Self) -> bool {
        let replicates = |of: &Self| match of.scheme {
            Scheme::Replicated(count) if !of.are_points => Some(count),
            _ => None,
        };
        let has_none = |of: &Self| matches!(of.scheme, Scheme::Without(_));
        !has_none(self) && !has_none(other) && replicates(self) == replicates(other)
    }

    /// Whether clusters are points with several rows each.
    pub fn are_points(&self) -> bool {
        self.are_points
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_of_a_point_are_one_cluster_and_points_without_value_are_none() {
        let draw = Draw::whole(Scheme::Independent, 2, vec![0; 4]);
        let clusters = draw.clusters([0, 1, 2, 6, 7].into_iter());
        assert_eq!((clusters.of.as_slice(), &clusters.scheme), (&[0, 0, 1, 3, 3][..], &Scheme::Replicated(4)));
        let mut kept = vec![0, 3, 3];
        assert_eq!((clusters.narrowed(&mut kept), kept), (Scheme::Replicated(2), vec![0, 1, 1]));
        assert!(matches!(draw.clusters([8].into_iter()).scheme, Scheme::Without(_)), "no such point");
        assert_eq!(
            Draw::whole(Scheme::Independent, 1, vec![0; 4]).clusters([9].into_iter()).scheme,
            Scheme::Independent
        );
    }
}
