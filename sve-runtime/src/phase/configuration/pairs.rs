//! Two configurations as one.

use super::{Configuration, Coordinates, FixedSize, WithRotations, largest};

/// Two configurations beside each other, such as the position and the attitude of a body. Their
/// stored values and their increments follow one another.
impl<Q: Configuration, R: Configuration> Configuration for (Q, R) {
    type Momentum = (Q::Momentum, R::Momentum);

    fn degrees_of_freedom(&self) -> usize {
        self.0.degrees_of_freedom() + self.1.degrees_of_freedom()
    }

    fn stored_values(&self) -> usize {
        self.0.stored_values() + self.1.stored_values()
    }

    #[inline(always)]
    fn store(&self, values: &mut [f64]) {
        let (first, second) = values.split_at_mut(self.0.stored_values());
        self.0.store(first);
        self.1.store(second);
    }

    #[inline(always)]
    fn restore(&mut self, values: &[f64]) {
        let (first, second) = values.split_at(self.0.stored_values());
        self.0.restore(first);
        self.1.restore(second);
    }

    #[inline(always)]
    fn retract(&mut self, increment: &[f64]) {
        let (first, second) = increment.split_at(self.0.degrees_of_freedom());
        self.0.retract(first);
        self.1.retract(second);
    }
}

impl<Q: FixedSize, R: FixedSize> FixedSize for (Q, R) {
    const DEGREES_OF_FREEDOM: usize = Q::DEGREES_OF_FREEDOM + R::DEGREES_OF_FREEDOM;
    const STORED_VALUES: usize = Q::STORED_VALUES + R::STORED_VALUES;
    const ENTRIES: usize = Q::ENTRIES + R::ENTRIES;
    const HAS_ROTATIONS: bool = Q::HAS_ROTATIONS || R::HAS_ROTATIONS;
    type FlatForm<Whole: FixedSize, const N: usize> = WithRotations<Whole, N>;
    type DualPart = (Q::DualPart, R::DualPart);

    fn dual_part(&self, along: &[f64]) -> (Q::DualPart, R::DualPart) {
        let (first, second) = along.split_at(Q::DEGREES_OF_FREEDOM);
        (self.0.dual_part(first), self.1.dual_part(second))
    }

    #[inline(always)]
    fn origin() -> Self {
        (Q::origin(), R::origin())
    }

    #[inline(always)]
    fn no_momentum() -> (Q::Momentum, R::Momentum) {
        (Q::no_momentum(), R::no_momentum())
    }

    #[inline(always)]
    fn entries(&self, values: &mut [f64]) {
        let (first, second) = values.split_at_mut(Q::ENTRIES);
        self.0.entries(first);
        self.1.entries(second);
    }

    #[inline(always)]
    fn add_transport(momentum: &[f64], velocity: &[f64], to: &mut [f64]) {
        let n = Q::DEGREES_OF_FREEDOM;
        let (first, second) = to.split_at_mut(n);
        Q::add_transport(&momentum[..n], &velocity[..n], first);
        R::add_transport(&momentum[n..], &velocity[n..], second);
    }

    #[inline(always)]
    fn turn_square(increment: &[f64]) -> f64 {
        let (first, second) = increment.split_at(Q::DEGREES_OF_FREEDOM);
        Q::turn_square(first).max(R::turn_square(second))
    }

    #[inline(always)]
    fn sum_of_stored_values(&self) -> f64 {
        self.0.sum_of_stored_values() + self.1.sum_of_stored_values()
    }

    #[inline]
    fn largest_stored_value(&self) -> f64 {
        largest([self.0.largest_stored_value(), self.1.largest_stored_value()].into_iter())
    }
}

impl<Q: FixedSize, R: FixedSize, const N: usize> Coordinates<N> for (Q, R) {
    type Flat = WithRotations<Self, N>;
    type Dual = (Q::DualPart, R::DualPart);

    fn dual(&self, along: &[f64; N]) -> Self::Dual {
        self.dual_part(along)
    }
}
