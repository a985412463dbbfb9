//! The macro that makes a system with compositions of its rules a [`Discretised`](crate::Discretised) system. Generated code calls it once for each system.

/// Implements [`Discretised`](crate::Discretised) for a system with compositions of its rules. A generic parameter hides a type of
/// the user with the same name, so the names of generic parameters begin with two underscores.
#[doc(hidden)]
#[macro_export]
macro_rules! __compositions {
    ($system:ty) => {
        $crate::__compositions! { @ $system, [__R, __C], $crate::Composed<__R, __C> }
        $crate::__compositions! { @ $system, [__C], $crate::Split<__C> }
    };
    (@ $system:ty, [$($generic:ident),*], $rule:ty) => {
        impl<$($generic),*> $crate::Discretised<$rule> for $system
        where
            $rule: $crate::__private::sequence::Sequence<Self>,
        {
            type Increments = <$rule as $crate::__private::sequence::Sequence<Self>>::Increments;
            type Prepared = <$rule as $crate::__private::sequence::Sequence<Self>>::Prepared;
            type Memory = <$rule as $crate::__private::sequence::Sequence<Self>>::Memory;
            const STAGES: usize =
                <$rule as $crate::__private::sequence::Sequence<Self>>::STAGES;
            const PLAN: &'static $crate::Plan =
                <$rule as $crate::__private::sequence::Sequence<Self>>::PLAN;
            const HAS_INCREMENTS: bool =
                <$rule as $crate::__private::sequence::Sequence<Self>>::HAS_INCREMENTS;

            fn prepare(&self, h: f64) -> Self::Prepared {
                <$rule as $crate::__private::sequence::Sequence<Self>>::prepare(self, h)
            }

            #[inline]
            fn advance(
                &self,
                newton: &$crate::Newton,
                prepared: &Self::Prepared,
                memory: &mut Self::Memory,
                state: &mut $crate::FlatStateOf<Self>,
                h: f64,
                dw: &Self::Increments,
            ) -> ::core::result::Result<(), $crate::StepError> {
                let shared = $crate::__private::sequence::Shared { system: self, newton, prepared };
                $crate::__private::sequence::advance::<$rule, _, _, _, _>(shared, memory, state, h, dw)
            }

            #[inline]
            fn advance_compensated(
                &self,
                newton: &$crate::Newton,
                prepared: &Self::Prepared,
                memory: &mut Self::Memory,
                state: [&mut $crate::FlatStateOf<Self>; 2],
                h: f64,
                dw: &Self::Increments,
            ) -> ::core::result::Result<(), $crate::StepError> {
                let shared = $crate::__private::sequence::Shared { system: self, newton, prepared };
                $crate::__private::sequence::advance_compensated::<$rule, _, _, _, _>(
                    shared, memory, state, h, dw,
                )
            }

            #[inline(always)]
            fn advance_lanes(
                &self,
                newton: &$crate::Newton,
                prepared: &Self::Prepared,
                states: &$crate::StateLanesOf<Self>,
                next: &mut $crate::StateLanesOf<Self>,
                h: f64,
                dw: &$crate::IncrementLanesOf<Self>,
            ) -> $crate::__private::Mask {
                let shared = $crate::__private::sequence::Shared { system: self, newton, prepared };
                $crate::__private::sequence::advance_lanes::<$rule, _, _, _, _>(
                    shared, states, next, h, dw,
                )
            }

            #[inline(always)]
            fn push_forward_lanes(
                &self,
                newton: &$crate::Newton,
                prepared: &Self::Prepared,
                states: &$crate::StateLanesOf<Self>,
                next: &mut $crate::StateLanesOf<Self>,
                h: f64,
                dw: &$crate::IncrementLanesOf<Self>,
                tangents: $crate::__private::lane::LaneDirections<
                    '_,
                    $crate::__private::lane::TangentLanesOf<Self>,
                >,
            ) -> [$crate::__private::Mask; 2] {
                let shared = $crate::__private::sequence::Shared { system: self, newton, prepared };
                $crate::__private::sequence::push_forward_lanes::<$rule, _, _, _, _>(
                    shared, states, next, h, dw, tangents,
                )
            }

            fn advance_with_derivatives(
                &self,
                newton: &$crate::Newton,
                state: &mut $crate::FlatStateOf<Self>,
                h: f64,
                dw: &Self::Increments,
            ) -> ::core::result::Result<$crate::__private::DMatrix, $crate::StepError> {
                let shared =
                    $crate::__private::sequence::Shared { system: self, newton, prepared: &() };
                $crate::__private::sequence::advance_with_derivatives::<$rule, _, _, _, _>(
                    shared, state, h, dw,
                )
            }

            fn push_forward(
                &self,
                newton: &$crate::Newton,
                prepared: &Self::Prepared,
                state: &mut $crate::FlatStateOf<Self>,
                h: f64,
                dw: &Self::Increments,
                directions: $crate::__private::Directions<'_, $crate::VectorOf<Self>>,
            ) -> ::core::result::Result<(), $crate::StepError> {
                let shared = $crate::__private::sequence::Shared { system: self, newton, prepared };
                $crate::__private::sequence::push_forward::<$rule, _, _, _, _>(
                    shared, state, h, dw, directions,
                )
            }

            fn pull_back(
                &self,
                newton: &$crate::Newton,
                prepared: &Self::Prepared,
                state: &$crate::FlatStateOf<Self>,
                h: f64,
                dw: &Self::Increments,
                covector: $crate::__private::Covector<'_, $crate::VectorOf<Self>>,
            ) -> ::core::result::Result<(), $crate::StepError> {
                let shared = $crate::__private::sequence::Shared { system: self, newton, prepared };
                $crate::__private::sequence::pull_back::<$rule, _, _, _, _>(
                    shared, state, h, dw, covector,
                )
            }

            fn newton_iterations(
                &self,
                newton: &$crate::Newton,
                prepared: &Self::Prepared,
                state: &$crate::FlatStateOf<Self>,
                h: f64,
                dw: &Self::Increments,
            ) -> ::core::option::Option<u32> {
                let shared = $crate::__private::sequence::Shared { system: self, newton, prepared };
                $crate::__private::sequence::newton_iterations::<$rule, _, _, _, _>(
                    shared, state, h, dw,
                )
            }
        }
    };
}
