//! Floating-point numbers for serde.
//!
//! Input: numbers, lists and arrays of them. Output: themselves; in human-readable formats, such as JSON, a number that is not finite becomes the
//! string `NaN`, `inf` or `-inf`, since JSON has no such numbers. Invariant: binary formats keep every bit.

use core::fmt;

use serde::de::{Error, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

#[allow(clippy::trivially_copy_pass_by_ref)] // as serde calls it
pub(crate) fn serialize<S: Serializer>(x: &f64, serializer: S) -> Result<S::Ok, S::Error> {
    if serializer.is_human_readable() && !x.is_finite() {
        serializer.collect_str(x)
    } else {
        serializer.serialize_f64(*x)
    }
}

pub(crate) fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f64, D::Error> {
    if deserializer.is_human_readable() {
        deserializer.deserialize_any(NumberOrName)
    } else {
        f64::deserialize(deserializer)
    }
}

struct NumberOrName;

impl Visitor<'_> for NumberOrName {
    type Value = f64;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a number, \"NaN\", \"inf\" or \"-inf\"")
    }

    fn visit_f64<E: Error>(self, x: f64) -> Result<f64, E> {
        Ok(x)
    }

    fn visit_i64<E: Error>(self, x: i64) -> Result<f64, E> {
        Ok(x as f64)
    }

    fn visit_u64<E: Error>(self, x: u64) -> Result<f64, E> {
        Ok(x as f64)
    }

    fn visit_str<E: Error>(self, name: &str) -> Result<f64, E> {
        match name {
            "NaN" => Ok(f64::NAN),
            "inf" => Ok(f64::INFINITY),
            "-inf" => Ok(f64::NEG_INFINITY),
            _ => Err(E::custom(format_args!("{name:?} is not a number"))),
        }
    }
}

/// One of a list.
#[derive(Serialize, Deserialize)]
#[serde(transparent)]
struct Float(#[serde(with = "self")] f64);

/// Lists.
pub(crate) mod many {
    use super::{Deserialize, Deserializer, Float, Serializer};

    pub(crate) fn serialize<S: Serializer>(x: &[f64], serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(x.iter().map(|&x| Float(x)))
    }

    pub(crate) fn deserialize<'de, D: Deserializer<'de>>(
        deserializer: D,
    ) -> Result<Vec<f64>, D::Error> {
        let floats = Vec::<Float>::deserialize(deserializer)?;
        Ok(floats.into_iter().map(|Float(x)| x).collect())
    }
}

/// Configurations: their stored values, whose number the type knows and the stored form leaves out.
pub(crate) mod configuration {
    use serde::{Deserializer, Serializer};

    use super::row;
    use crate::configuration::FixedSize;

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
    use crate::configuration::FixedSize;

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

/// Values of a known number.
mod row {
    use core::fmt;

    use serde::de::{Error, SeqAccess, Visitor};
    use serde::ser::SerializeTuple;
    use serde::{Deserializer, Serializer};

    use super::Float;
    use crate::configuration::Configuration;

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
