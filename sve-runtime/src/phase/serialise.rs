//! Configurations and momenta for serde.
//!
//! Input: a configuration or a momentum. Output: the row of its stored values.

/// Configurations as their stored values. The type knows their number, so it is not stored.
pub(crate) mod configuration {
    use serde::{Deserializer, Serializer};

    use super::row;
    use crate::phase::configuration::FixedSize;

    pub(crate) fn serialize<Q: FixedSize, S: Serializer>(
        q: &Q,
        serializer: S,
    ) -> Result<S::Ok, S::Error> {
        row::serialize(q, Q::STORED_VALUES, serializer)
    }

    pub(crate) fn deserialize<'de, Q: FixedSize, D: Deserializer<'de>>(
        deserializer: D,
    ) -> Result<Q, D::Error> {
        row::deserialize(Q::origin(), Q::STORED_VALUES, deserializer)
    }
}

/// Momenta of a configuration.
pub(crate) mod momentum {
    use serde::{Deserializer, Serializer};

    use super::row;
    use crate::phase::configuration::FixedSize;

    pub(crate) fn serialize<Q: FixedSize, S: Serializer>(
        p: &Q::Momentum,
        serializer: S,
    ) -> Result<S::Ok, S::Error> {
        row::serialize(p, Q::DEGREES_OF_FREEDOM, serializer)
    }

    pub(crate) fn deserialize<'de, Q: FixedSize, D: Deserializer<'de>>(
        deserializer: D,
    ) -> Result<Q::Momentum, D::Error> {
        row::deserialize(Q::no_momentum(), Q::DEGREES_OF_FREEDOM, deserializer)
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
