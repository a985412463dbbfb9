//! Arrays of configurations: several bodies.

use super::{Configuration, Coordinates, FixedSize, FlatConfiguration, largest};

/// Several bodies. Their stored values and their increments follow one another in the order of the
/// bodies.
impl<Q: Configuration, const B: usize> Configuration for [Q; B] {
    type Momentum = [Q::Momentum; B];

    fn degrees_of_freedom(&self) -> usize {
        self.iter().map(Q::degrees_of_freedom).sum()
    }

    fn stored_values(&self) -> usize {
        self.iter().map(Q::stored_values).sum()
    }

    #[inline(always)]
    fn store(&self, values: &mut [f64]) {
        let mut rest = values;
        for body in self {
            let (own, others) = rest.split_at_mut(body.stored_values());
            body.store(own);
            rest = others;
        }
        assert!(rest.is_empty(), "more values than the configuration has");
    }

    #[inline(always)]
    fn restore(&mut self, values: &[f64]) {
        let mut rest = values;
        for body in self {
            let (own, others) = rest.split_at(body.stored_values());
            body.restore(own);
            rest = others;
        }
        assert!(rest.is_empty(), "more values than the configuration has");
    }

    #[inline(always)]
    fn retract(&mut self, increment: &[f64]) {
        let mut rest = increment;
        for body in self {
            let (own, others) = rest.split_at(body.degrees_of_freedom());
            body.retract(own);
            rest = others;
        }
        assert!(
            rest.is_empty(),
            "an increment longer than the degrees of freedom"
        );
    }
}

impl<Q: FixedSize, const B: usize> FixedSize for [Q; B] {
    const DEGREES_OF_FREEDOM: usize = B * Q::DEGREES_OF_FREEDOM;
    const STORED_VALUES: usize = B * Q::STORED_VALUES;
    const ENTRIES: usize = B * Q::ENTRIES;
    const HAS_ROTATIONS: bool = Q::HAS_ROTATIONS;
    type FlatForm<Whole: FixedSize, const N: usize> = Q::FlatForm<Whole, N>;
    type DualPart = [Q::DualPart; B];

    fn dual_part(&self, along: &[f64]) -> [Q::DualPart; B] {
        let n = Q::DEGREES_OF_FREEDOM;
        core::array::from_fn(|b| self[b].dual_part(&along[n * b..n * (b + 1)]))
    }

    #[inline(always)]
    fn origin() -> Self {
        [Q::origin(); B]
    }

    #[inline(always)]
    fn no_momentum() -> [Q::Momentum; B] {
        [Q::no_momentum(); B]
    }

    #[inline(always)]
    fn entries(&self, values: &mut [f64]) {
        let mut rest = values;
        for body in self {
            let (own, others) = rest.split_at_mut(Q::ENTRIES);
            body.entries(own);
            rest = others;
        }
        assert!(rest.is_empty(), "more values than the configuration has");
    }

    #[inline(always)]
    fn add_transport(momentum: &[f64], velocity: &[f64], to: &mut [f64]) {
        if Q::HAS_ROTATIONS {
            let n = Q::DEGREES_OF_FREEDOM;
            let bodies = momentum.chunks(n).zip(velocity.chunks(n));
            for ((momentum, velocity), to) in bodies.zip(to.chunks_mut(n)) {
                Q::add_transport(momentum, velocity, to);
            }
        }
    }

    #[inline(always)]
    fn turn_square(increment: &[f64]) -> f64 {
        if !Q::HAS_ROTATIONS {
            return 0.0;
        }
        let bodies = increment.chunks(Q::DEGREES_OF_FREEDOM);
        bodies.map(Q::turn_square).fold(0.0, f64::max)
    }

    #[inline(always)]
    fn sum_of_stored_values(&self) -> f64 {
        self.iter().map(Q::sum_of_stored_values).sum()
    }

    #[inline]
    fn largest_stored_value(&self) -> f64 {
        largest(self.iter().map(Q::largest_stored_value))
    }
}

impl<Q: FixedSize, const B: usize, const N: usize> Coordinates<N> for [Q; B] {
    type Flat = Q::FlatForm<Self, N>;
    type Dual = <Q::FlatForm<Self, N> as FlatConfiguration<N>>::Dual;

    fn dual(&self, along: &[f64; N]) -> Self::Dual {
        self.coordinates().dual(along)
    }
}
