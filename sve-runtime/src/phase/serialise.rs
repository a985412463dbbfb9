//! Configurations and momenta for serde.
//!
//! Input: a configuration or a momentum. Output: the row of its stored values.

use serde::de::Error as _;
use serde::{Deserializer, Serializer};

use crate::floats::many;
use crate::phase::configuration::{Configuration, FixedSize, Site};

/// A configuration with a form for serde: the row of its stored values. If the type does not know
/// their number, it is stored.
pub trait Serialised: Configuration {
    /// Writes a configuration.
    ///
    /// # Errors
    /// Errors of the format.
    fn write<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error>;
    /// Reads a configuration.
    ///
    /// # Errors
    /// Errors of the format; an error for another number of values.
    fn read<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error>;
    /// Writes a momentum.
    ///
    /// # Errors
    /// As [`write`](Self::write).
    fn write_momentum<S: Serializer>(p: &Self::Momentum, to: S) -> Result<S::Ok, S::Error>;
    /// Reads a momentum.
    ///
    /// # Errors
    /// As [`read`](Self::read).
    fn read_momentum<'de, D: Deserializer<'de>>(from: D) -> Result<Self::Momentum, D::Error>;
}

impl<Q: FixedSize> Serialised for Q {
    fn write<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        row::serialize(self, Q::STORED_VALUES, serializer)
    }

    fn read<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Q, D::Error> {
        row::deserialize(Q::origin(), Q::STORED_VALUES, deserializer)
    }

    fn write_momentum<S: Serializer>(p: &Q::Momentum, to: S) -> Result<S::Ok, S::Error> {
        row::serialize(p, Q::DEGREES_OF_FREEDOM, to)
    }

    fn read_momentum<'de, D: Deserializer<'de>>(from: D) -> Result<Q::Momentum, D::Error> {
        row::deserialize(Q::no_momentum(), Q::DEGREES_OF_FREEDOM, from)
    }
}

impl<Q: Site> Serialised for Vec<Q> {
    fn write<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut values = vec![0.0; self.stored_values()];
        self.store(&mut values);
        many::serialize(&values, serializer)
    }

    fn read<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let values = many::deserialize(deserializer)?;
        let sites = values.len() / Q::NUMBERS.max(1);
        if sites * Q::NUMBERS != values.len() {
            let of = format_args!("a multiple of {} numbers", Q::NUMBERS).to_string();
            return Err(D::Error::invalid_length(values.len(), &of.as_str()));
        }
        let mut q = vec![Q::zero(); sites];
        q.restore(&values);
        Ok(q)
    }

    fn write_momentum<S: Serializer>(p: &Self, to: S) -> Result<S::Ok, S::Error> {
        p.write(to)
    }

    fn read_momentum<'de, D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        Self::read(from)
    }
}

/// Rows with a known number of values.
mod row {
    use core::fmt;

    use serde::de::{Error, SeqAccess, Visitor};
    use serde::ser::SerializeTuple;
    use serde::{Deserializer, Serializer};

    use crate::floats::Float;
    use crate::phase::configuration::Configuration;

    pub(super) fn serialize<Q: Configuration, S: Serializer>(
        q: &Q,
        length: usize,
        serializer: S,
    ) -> Result<S::Ok, S::Error> {
        let mut values = vec![0.0; length];
        q.store(&mut values);
        let mut tuple = serializer.serialize_tuple(length)?;
        for x in values {
            tuple.serialize_element(&Float(x))?;
        }
        tuple.end()
    }

    pub(super) fn deserialize<'de, Q: Configuration, D: Deserializer<'de>>(
        mut q: Q,
        length: usize,
        deserializer: D,
    ) -> Result<Q, D::Error> {
        let values = deserializer.deserialize_tuple(length, Values(length))?;
        q.restore(&values);
        Ok(q)
    }

    struct Values(usize);

    impl<'de> Visitor<'de> for Values {
        type Value = Vec<f64>;

        fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            write!(f, "{} numbers", self.0)
        }

        fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<Vec<f64>, A::Error> {
            let mut values = vec![0.0; self.0];
            for (i, x) in values.iter_mut().enumerate() {
                let Float(next) = seq
                    .next_element()?
                    .ok_or_else(|| A::Error::invalid_length(i, &self))?;
                *x = next;
            }
            if seq.next_element::<Float>()?.is_some() {
                return Err(A::Error::invalid_length(self.0 + 1, &self));
            }
            Ok(values)
        }
    }
}
