//! The statistics of an ensemble: results that are collected from the observables of all paths, and
//! merged.
//!
//! Input: the observables of tiles at recorded times, and the ends of paths. Output: results that
//! merge, and the public statistics made from them. Invariant: a statistic is one file, with its
//! request, its setting of [`Ensemble`], its results, and its public form with the functions of
//! [`Summary`] that return it; and one line of the list in this file. All other code (settings,
//! sizes, blocks, merge tree, stored form) knows lists of statistics only.

use core::any::Any;
use core::panic::{RefUnwindSafe, UnwindSafe};

use super::antithetic::Pairs;
use super::covariance::Joint;
use super::difference::Difference;
use super::histogram::BinCounts;
use super::passage::counts::{PassageCounts, PathEnds};
use super::quantiles::Sketches;
use super::statistics::Moments;
use super::{Ensemble, EnsembleError, Summary};
use crate::ensemble::PathMethod;
use crate::lanes::{Lane, Mask};

/// The results of one statistic over some consecutive blocks of paths.
pub(super) trait Statistic: Sized {
    /// The request: the observables and the options of the statistic.
    type Request;

    /// The difference between two runs whose requests of this statistic differ.
    const DIFFERENCE: Difference;
    /// The statistic is also taken of the differences of two runs with common noise.
    const IS_OF_DIFFERENCES: bool = false;
    /// The errors of the statistic suppose that all paths are independent.
    const NEEDS_INDEPENDENT_PATHS: bool = false;

    /// Checks a request, for observables of these names.
    fn check(request: &Self::Request, names: &[String]) -> Result<(), EnsembleError> {
        let _ = (request, names);
        Ok(())
    }

    /// Returns the memory that a run needs.
    fn size(request: &Self::Request, extent: &Extent<'_>) -> Size;

    /// Returns whether [`Recorded::history`] is needed.
    fn needs_history(request: &Self::Request) -> bool {
        let _ = request;
        false
    }

    /// The results of a block before its first record, for a request that has been checked.
    fn empty(request: &Self::Request, extent: &Extent<'_>) -> Self;

    /// Adds the observables of a tile.
    fn add(&mut self, at: &Recorded<'_>) {
        let _ = at;
    }

    /// Adds the ends of the paths of a block.
    fn end(&mut self, ends: &PathEnds) {
        let _ = ends;
    }

    /// Adds the results of the next blocks. `counts` and `others` are the numbers of paths at each
    /// recorded time, in these results and in the other results.
    fn merge(&mut self, counts: &[u64], other: &Self, others: &[u64]);

    /// Returns whether results that were read from a file belong to a request, with so many paths
    /// at each recorded time.
    #[cfg(feature = "serde")]
    fn fits(&self, request: &Self::Request, extent: &Extent<'_>, counts: &[u64]) -> bool;

    /// Adds the public form to a summary that has the data of the run and the counts.
    fn show(self, summary: &mut Summary);
}

/// The numbers on which the size of results depends.
pub(super) struct Extent<'a> {
    /// The names of the observables.
    pub(super) names: &'a [String],
    /// Number of recorded times.
    pub(super) records: u64,
    /// Number of paths.
    pub(super) paths: u64,
    /// Number of bins between two recorded times in which passages are counted.
    pub(super) passage_bins: u64,
}

impl Extent<'_> {
    /// Returns the number of recorded times of results that fit into memory.
    pub(super) fn rows(&self) -> usize {
        usize::try_from(self.records).unwrap_or(usize::MAX)
    }

    /// Returns the number of an observable, whose name has been checked.
    pub(super) fn column(&self, name: &str) -> usize {
        let known = self.names.iter().position(|known| known == name);
        known.unwrap_or(self.names.len())
    }
}

/// The memory that a statistic needs.
pub(super) struct Size {
    pub(super) bytes: u128,
    /// The setting that needs the memory.
    pub(super) what: String,
    /// The remedy that needs less memory.
    pub(super) remedy: &'static str,
}

/// The observables of a tile at a recorded time.
pub(super) struct Recorded<'a> {
    /// Number of the recorded time.
    pub(super) record: usize,
    /// Numbers of paths at each recorded time, without the paths of the tile.
    pub(super) counts: &'a [u64],
    /// The observables.
    pub(super) values: &'a [Lane],
    /// The lanes whose paths count.
    pub(super) lanes: Mask,
    /// The observables of the tile at the recorded times before, if a statistic needs them.
    pub(super) history: &'a [&'a [Lane]],
}

/// Checks that there is an observable of this name.
pub(super) fn check_known(
    name: &str,
    names: &[String],
    purpose: &'static str,
) -> Result<(), EnsembleError> {
    if names.iter().any(|known| known == name) {
        return Ok(());
    }
    Err(EnsembleError::UnknownObservable {
        name: name.to_owned(),
        purpose,
        known: names.to_vec(),
    })
}

/// Makes the enums over all statistics, which call the functions of [`Statistic`].
macro_rules! statistics {
    ($($kind:ident($statistic:ty),)*) => {
        /// A kind of statistic.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
        pub(super) enum Kind { $($kind),* }

        /// The request of any statistic.
        #[derive(Clone, Debug, PartialEq)]
        #[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
        pub(super) enum AnyRequest { $($kind(<$statistic as Statistic>::Request)),* }

        /// The results of any statistic.
        #[derive(Clone, Debug, PartialEq)]
        #[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
        pub(super) enum AnyStatistic { $($kind($statistic)),* }

        impl AnyRequest {
            pub(super) fn kind(&self) -> Kind {
                match self { $(Self::$kind(_) => Kind::$kind),* }
            }

            pub(super) fn is_of_differences(&self) -> bool {
                match self { $(Self::$kind(_) => <$statistic>::IS_OF_DIFFERENCES),* }
            }

            pub(super) fn needs_independent_paths(&self) -> bool {
                match self { $(Self::$kind(_) => <$statistic>::NEEDS_INDEPENDENT_PATHS),* }
            }

            pub(super) fn check(&self, names: &[String]) -> Result<(), EnsembleError> {
                match self { $(Self::$kind(request) => <$statistic>::check(request, names)),* }
            }

            pub(super) fn size(&self, extent: &Extent<'_>) -> Size {
                match self { $(Self::$kind(request) => <$statistic>::size(request, extent)),* }
            }

            pub(super) fn needs_history(&self) -> bool {
                match self { $(Self::$kind(request) => <$statistic>::needs_history(request)),* }
            }

            pub(super) fn empty(&self, extent: &Extent<'_>) -> AnyStatistic {
                match self {
                    $(Self::$kind(request) => AnyStatistic::$kind(Statistic::empty(request, extent))),*
                }
            }

            fn difference(&self) -> Difference {
                match self { $(Self::$kind(_) => <$statistic>::DIFFERENCE),* }
            }
        }

        impl AnyStatistic {
            pub(super) fn is_of_differences(&self) -> bool {
                match self { $(Self::$kind(_) => <$statistic>::IS_OF_DIFFERENCES),* }
            }

            pub(super) fn add(&mut self, at: &Recorded<'_>) {
                match self { $(Self::$kind(statistic) => statistic.add(at)),* }
            }

            pub(super) fn end(&mut self, ends: &PathEnds) {
                match self { $(Self::$kind(statistic) => statistic.end(ends)),* }
            }

            pub(super) fn merge(&mut self, counts: &[u64], other: &Self, others: &[u64]) {
                match (self, other) {
                    $((Self::$kind(own), Self::$kind(other)) => own.merge(counts, other, others),)*
                    _ => unreachable!("results of one run are of the same statistics"),
                }
            }

            #[cfg(feature = "serde")]
            pub(super) fn fits(&self, request: &AnyRequest, extent: &Extent<'_>, counts: &[u64]) -> bool {
                match (self, request) {
                    $((Self::$kind(own), AnyRequest::$kind(request)) => own.fits(request, extent, counts),)*
                    _ => false,
                }
            }

            pub(super) fn show(self, summary: &mut Summary) {
                match self { $(Self::$kind(statistic) => statistic.show(summary)),* }
            }
        }
    };
}
// The order is the order in which runs are compared. A statistic that is read with the help of
// another statistic stands after it.
statistics! {
    Moments(Moments),
    Passages(PassageCounts),
    Histogram(BinCounts),
    Covariance(Joint),
    Quantiles(Sketches),
    Pairs(Pairs),
}

impl<I: PathMethod, K> Ensemble<'_, I, K> {
    /// Requests a statistic. Requests stand in the order of their kinds, so that it does not matter
    /// which kind was asked for first.
    pub(super) fn take(mut self, request: AnyRequest) -> Self {
        let kind = request.kind();
        let place = self
            .observed
            .statistics
            .partition_point(|other| other.kind() <= kind);
        self.observed.statistics.insert(place, request);
        self
    }
}

/// Returns the difference between two runs with these requests.
pub(super) fn difference(own: &[AnyRequest], other: &[AnyRequest]) -> Option<Difference> {
    let first = (0..own.len().max(other.len())).find(|&i| own.get(i) != other.get(i))?;
    let requests = [own.get(first), other.get(first)].into_iter().flatten();
    let of_first_kind = requests.min_by_key(|request| request.kind());
    of_first_kind.map(AnyRequest::difference)
}

/// The results of all statistics as users read them: a list for each type.
#[derive(Clone, Default)]
pub(super) struct Shown(Vec<Box<dyn List>>);

/// A list of items of one type.
trait List: Any + Send + Sync + UnwindSafe + RefUnwindSafe {
    fn boxed_clone(&self) -> Box<dyn List>;
}

impl<T> List for Vec<T>
where
    T: Clone + Send + Sync + UnwindSafe + RefUnwindSafe + 'static,
{
    fn boxed_clone(&self) -> Box<dyn List> {
        Box::new(self.clone())
    }
}

impl Clone for Box<dyn List> {
    fn clone(&self) -> Self {
        (**self).boxed_clone()
    }
}

impl Shown {
    /// Adds an item to the list of its type.
    pub(super) fn push<T>(&mut self, item: T)
    where
        T: Clone + Send + Sync + UnwindSafe + RefUnwindSafe + 'static,
    {
        match self.list_mut::<T>() {
            Some(list) => list.push(item),
            None => self.0.push(Box::new(vec![item])),
        }
    }

    /// Returns the items of a type, in the order in which they were added.
    pub(super) fn all<T: 'static>(&self) -> &[T] {
        let mut lists = self.0.iter();
        let list = lists.find_map(|list| (&**list as &dyn Any).downcast_ref::<Vec<T>>());
        list.map_or(&[], Vec::as_slice)
    }

    /// Returns the list of a type, unless it is empty.
    pub(super) fn list_mut<T: 'static>(&mut self) -> Option<&mut Vec<T>> {
        let mut lists = self.0.iter_mut();
        lists.find_map(|list| (&mut **list as &mut dyn Any).downcast_mut())
    }
}

#[cfg(test)]
mod tests {
    use super::{AnyRequest, difference};
    use crate::ensemble::antithetic::PairsRequest;
    use crate::ensemble::difference::Difference;
    use crate::ensemble::quantiles::QuantileRequest;
    use crate::ensemble::statistics::MomentsRequest;

    #[test]
    fn runs_differ_in_the_first_kind_of_which_their_requests_differ() {
        let quantiles = |size| {
            let name = "q".to_owned();
            AnyRequest::Quantiles(QuantileRequest { name, size })
        };
        let moments = AnyRequest::Moments(MomentsRequest);
        let pairs = AnyRequest::Pairs(PairsRequest);
        let plain = [moments.clone()];
        let ten = [moments.clone(), quantiles(10)];
        let twenty = [moments.clone(), quantiles(20)];
        let paired = [moments, pairs];
        let of_quantiles = Some(Difference::Statistic("quantiles"));
        for (own, other, expected) in [
            (&plain[..], &plain[..], None),
            (&plain, &ten, of_quantiles),
            (&ten, &twenty, of_quantiles),
            (&ten, &paired, of_quantiles),
            (&plain, &paired, Some(Difference::Noise)),
        ] {
            assert_eq!(difference(own, other), expected);
            assert_eq!(difference(other, own), expected);
        }
    }
}
