//! Errors whose `Debug` is their message.
//!
//! A `main` that returns an error prints it with `Debug`, and so do `unwrap` and `expect`. Input:
//! types with `Display`. Output: their `Debug`, with the same text.

/// Prints errors with `Debug` as with `Display`.
macro_rules! debug_is_display {
    ($($error:ty),* $(,)?) => {
        $(
            impl ::core::fmt::Debug for $error {
                fn fmt(&self, f: &mut ::core::fmt::Formatter<'_>) -> ::core::fmt::Result {
                    ::core::fmt::Display::fmt(self, f)
                }
            }
        )*
    };
}

pub(crate) use debug_is_display;

#[cfg(test)]
mod tests {
    use crate::error::StepError;
    use crate::noise::NoiseError;

    #[test]
    fn the_form_for_developers_is_the_message() {
        let errors = [
            StepError::StepSize { h: 0.0 },
            StepError::Noise {
                t: 0.5,
                source: NoiseError::Depth { depth: 64 },
            },
        ];
        for error in errors {
            assert_eq!(format!("{error:?}"), error.to_string());
            assert_eq!(format!("{error:#?}"), error.to_string());
        }
    }
}
