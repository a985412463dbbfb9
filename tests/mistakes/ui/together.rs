//! Files with one mistake or a few each, compiled at once: each error is the one of its file, and no other follows.

#[path = "constraint/breaks_a_symmetry.rs"]
mod constraint_breaks_a_symmetry;
#[path = "constraint/curved_with_endpoint.rs"]
mod constraint_curved_with_endpoint;
#[path = "constraint/depends_on_velocity.rs"]
mod constraint_depends_on_velocity;
#[path = "constraint/duplicated.rs"]
mod constraint_duplicated;
#[path = "constraint/gauss.rs"]
mod constraint_gauss;
#[path = "constraint/misspelt.rs"]
mod constraint_misspelt;
#[path = "constraint/no_configuration.rs"]
mod constraint_no_configuration;
#[path = "constraint/not_smooth.rs"]
mod constraint_not_smooth;
#[path = "constraint/not_tangent.rs"]
mod constraint_not_tangent;
#[path = "constraint/other_argument_of_h1.rs"]
mod constraint_other_argument_of_h1;
#[path = "constraint/other_length.rs"]
mod constraint_other_length;
#[path = "constraint/relativistic.rs"]
mod constraint_relativistic;
#[path = "constraint/returns_a_matrix.rs"]
mod constraint_returns_a_matrix;
#[path = "constraint/squared.rs"]
mod constraint_squared;
#[path = "constraint/sum_of_others.rs"]
mod constraint_sum_of_others;
#[path = "constraint/tangent_without_constraint.rs"]
mod constraint_tangent_without_constraint;
#[path = "constraint/taylor2.rs"]
mod constraint_taylor2;
#[path = "constraint/weak2.rs"]
mod constraint_weak2;
#[path = "constraint/with_arguments.rs"]
mod constraint_with_arguments;
#[path = "constraint/without_position.rs"]
mod constraint_without_position;
#[path = "degenerate/coordinate_that_does_not_occur.rs"]
mod degenerate_coordinate_that_does_not_occur;
#[path = "degenerate/force.rs"]
mod degenerate_force;
#[path = "degenerate/gauss.rs"]
mod degenerate_gauss;
#[path = "degenerate/gradient.rs"]
mod degenerate_gradient;
#[path = "degenerate/mass_without_velocity.rs"]
mod degenerate_mass_without_velocity;
#[path = "degenerate/masses_of_a_sum.rs"]
mod degenerate_masses_of_a_sum;
#[path = "degenerate/multiplier.rs"]
mod degenerate_multiplier;
#[path = "degenerate/noise_of_momenta.rs"]
mod degenerate_noise_of_momenta;
#[path = "degenerate/noise_without_inertia.rs"]
mod degenerate_noise_without_inertia;
#[path = "degenerate/odd_number_of_coordinates.rs"]
mod degenerate_odd_number_of_coordinates;
#[path = "degenerate/one_sided.rs"]
mod degenerate_one_sided;
#[path = "degenerate/one_sided_with_masses.rs"]
mod degenerate_one_sided_with_masses;
#[path = "degenerate/stormer_verlet.rs"]
mod degenerate_stormer_verlet;
#[path = "degenerate/taylor2.rs"]
mod degenerate_taylor2;
#[path = "degenerate/time_dependent.rs"]
mod degenerate_time_dependent;
#[path = "degenerate/two_multipliers.rs"]
mod degenerate_two_multipliers;
#[path = "degenerate/weak2.rs"]
mod degenerate_weak2;
#[path = "force/also_a_noise.rs"]
mod force_also_a_noise;
#[path = "force/not_smooth.rs"]
mod force_not_smooth;
#[path = "force/number_for_a_vector.rs"]
mod force_number_for_a_vector;
#[path = "force/other_length.rs"]
mod force_other_length;
#[path = "force/returns_too_few.rs"]
mod force_returns_too_few;
#[path = "force/without_velocity.rs"]
mod force_without_velocity;
#[path = "language/absolute_value.rs"]
mod language_absolute_value;
#[path = "language/argument_missing.rs"]
mod language_argument_missing;
#[path = "language/argument_of_sine.rs"]
mod language_argument_of_sine;
#[path = "language/array_for_number.rs"]
mod language_array_for_number;
#[path = "language/array_method.rs"]
mod language_array_method;
#[path = "language/array_too_large.rs"]
mod language_array_too_large;
#[path = "language/assertion.rs"]
mod language_assertion;
#[path = "language/body_too_large.rs"]
mod language_body_too_large;
#[path = "language/caret_as_power.rs"]
mod language_caret_as_power;
#[path = "language/cast.rs"]
mod language_cast;
#[path = "language/cast_of_a_field.rs"]
mod language_cast_of_a_field;
#[path = "language/changed_by_a_helper.rs"]
mod language_changed_by_a_helper;
#[path = "language/changed_in_a_map.rs"]
mod language_changed_in_a_map;
#[path = "language/clamp.rs"]
mod language_clamp;
#[path = "language/closure_not_called.rs"]
mod language_closure_not_called;
#[path = "language/closure_of_two.rs"]
mod language_closure_of_two;
#[path = "language/closure_that_counts.rs"]
mod language_closure_that_counts;
#[path = "language/closure_with_effect.rs"]
mod language_closure_with_effect;
#[path = "language/collect.rs"]
mod language_collect;
#[path = "language/comparison.rs"]
mod language_comparison;
#[path = "language/constant_not_here.rs"]
mod language_constant_not_here;
#[path = "language/division_by_zero.rs"]
mod language_division_by_zero;
#[path = "language/division_of_integers.rs"]
mod language_division_of_integers;
#[path = "language/endless_loop.rs"]
mod language_endless_loop;
#[path = "language/entries_of_a_number.rs"]
mod language_entries_of_a_number;
#[path = "language/exponent_not_known.rs"]
mod language_exponent_not_known;
#[path = "language/field_without_self.rs"]
mod language_field_without_self;
#[path = "language/filter_on_numbers.rs"]
mod language_filter_on_numbers;
#[path = "language/float_as_exponent_of_powi.rs"]
mod language_float_as_exponent_of_powi;
#[path = "language/floor.rs"]
mod language_floor;
#[path = "language/function_as_an_argument.rs"]
mod language_function_as_an_argument;
#[path = "language/function_in_a_body.rs"]
mod language_function_in_a_body;
#[path = "language/function_without_self_as_method.rs"]
mod language_function_without_self_as_method;
#[path = "language/if_expression.rs"]
mod language_if_expression;
#[path = "language/index_is_a_float.rs"]
mod language_index_is_a_float;
#[path = "language/index_not_known.rs"]
mod language_index_not_known;
#[path = "language/index_out_of_range.rs"]
mod language_index_out_of_range;
#[path = "language/index_overflow.rs"]
mod language_index_overflow;
#[path = "language/integer_constant.rs"]
mod language_integer_constant;
#[path = "language/integer_for_a_closure.rs"]
mod language_integer_for_a_closure;
#[path = "language/integer_for_float.rs"]
mod language_integer_for_float;
#[path = "language/integer_overflow.rs"]
mod language_integer_overflow;
#[path = "language/integer_overflow_of_i32.rs"]
mod language_integer_overflow_of_i32;
#[path = "language/integer_variable.rs"]
mod language_integer_variable;
#[path = "language/inverse_sine_by_another_name.rs"]
mod language_inverse_sine_by_another_name;
#[path = "language/iter_mut_of_a_field.rs"]
mod language_iter_mut_of_a_field;
#[path = "language/last_of_an_array.rs"]
mod language_last_of_an_array;
#[path = "language/length_of_a_field.rs"]
mod language_length_of_a_field;
#[path = "language/length_of_from_fn.rs"]
mod language_length_of_from_fn;
#[path = "language/let_else.rs"]
mod language_let_else;
#[path = "language/literal_out_of_range.rs"]
mod language_literal_out_of_range;
#[path = "language/loop_bound_not_known.rs"]
mod language_loop_bound_not_known;
#[path = "language/loop_too_large.rs"]
mod language_loop_too_large;
#[path = "language/macro_call.rs"]
mod language_macro_call;
#[path = "language/match_expression.rs"]
mod language_match_expression;
#[path = "language/maximum.rs"]
mod language_maximum;
#[path = "language/minimum.rs"]
mod language_minimum;
#[path = "language/misspelt_constant_of_the_library.rs"]
mod language_misspelt_constant_of_the_library;
#[path = "language/misspelt_helper.rs"]
mod language_misspelt_helper;
#[path = "language/misspelt_method.rs"]
mod language_misspelt_method;
#[path = "language/misspelt_variable.rs"]
mod language_misspelt_variable;
#[path = "language/mistake_in_a_closure_called_twice.rs"]
mod language_mistake_in_a_closure_called_twice;
#[path = "language/mistake_in_a_helper_used_twice.rs"]
mod language_mistake_in_a_helper_used_twice;
#[path = "language/mistake_in_a_loop.rs"]
mod language_mistake_in_a_loop;
#[path = "language/mistakes_in_two_functions.rs"]
mod language_mistakes_in_two_functions;
#[path = "language/mutable_reference.rs"]
mod language_mutable_reference;
#[path = "language/name_from_another_language.rs"]
mod language_name_from_another_language;
#[path = "language/negative_cast.rs"]
mod language_negative_cast;
#[path = "language/negative_index.rs"]
mod language_negative_index;
#[path = "language/no_such_component.rs"]
mod language_no_such_component;
#[path = "language/outer_constant_as_bound.rs"]
mod language_outer_constant_as_bound;
#[path = "language/outer_constant_as_length.rs"]
mod language_outer_constant_as_length;
#[path = "language/outer_constant_of_a_type.rs"]
mod language_outer_constant_of_a_type;
#[path = "language/own_constant_without_self.rs"]
mod language_own_constant_without_self;
#[path = "language/own_function_without_self.rs"]
mod language_own_function_without_self;
#[path = "language/parameter_length.rs"]
mod language_parameter_length;
#[path = "language/pattern_of_a_number.rs"]
mod language_pattern_of_a_number;
#[path = "language/pattern_too_short.rs"]
mod language_pattern_too_short;
#[path = "language/power_out_of_proportion.rs"]
mod language_power_out_of_proportion;
#[path = "language/question_mark.rs"]
mod language_question_mark;
#[path = "language/recursion.rs"]
mod language_recursion;
#[path = "language/recursive_constant.rs"]
mod language_recursive_constant;
#[path = "language/remainder.rs"]
mod language_remainder;
#[path = "language/remainder_in_a_condition.rs"]
mod language_remainder_in_a_condition;
#[path = "language/return_statement.rs"]
mod language_return_statement;
#[path = "language/rounding_in_a_condition.rs"]
mod language_rounding_in_a_condition;
#[path = "language/self_as_a_number.rs"]
mod language_self_as_a_number;
#[path = "language/semicolon_after_the_value.rs"]
mod language_semicolon_after_the_value;
#[path = "language/sign.rs"]
mod language_sign;
#[path = "language/sine_as_a_function.rs"]
mod language_sine_as_a_function;
#[path = "language/single_precision.rs"]
mod language_single_precision;
#[path = "language/structure.rs"]
mod language_structure;
#[path = "language/sum_of_integers.rs"]
mod language_sum_of_integers;
#[path = "language/three_mistakes.rs"]
mod language_three_mistakes;
#[path = "language/tuple_for_number.rs"]
mod language_tuple_for_number;
#[path = "language/two_stars_as_power.rs"]
mod language_two_stars_as_power;
#[path = "language/two_types_of_integers.rs"]
mod language_two_types_of_integers;
#[path = "language/undefined_constant.rs"]
mod language_undefined_constant;
#[path = "language/unknown_function.rs"]
mod language_unknown_function;
#[path = "language/while_loop.rs"]
mod language_while_loop;
#[path = "language/wrong_number_of_arguments.rs"]
mod language_wrong_number_of_arguments;
#[path = "language/zero_to_a_negative_power.rs"]
mod language_zero_to_a_negative_power;
#[path = "model/by_reference.rs"]
mod model_by_reference;
#[path = "model/length_by_an_outer_constant.rs"]
mod model_length_by_an_outer_constant;
#[path = "model/length_from_outside.rs"]
mod model_length_from_outside;
#[path = "model/length_of_a_module.rs"]
mod model_length_of_a_module;
#[path = "model/lengths_differ.rs"]
mod model_lengths_differ;
#[path = "model/nearly_degenerate.rs"]
mod model_nearly_degenerate;
#[path = "model/no_coordinates.rs"]
mod model_no_coordinates;
#[path = "model/number_and_array.rs"]
mod model_number_and_array;
#[path = "model/own_length_without_self.rs"]
mod model_own_length_without_self;
#[path = "model/scalar_velocity_missing.rs"]
mod model_scalar_velocity_missing;
#[path = "model/single_precision.rs"]
mod model_single_precision;
#[path = "model/slices_of_coordinates.rs"]
mod model_slices_of_coordinates;
#[path = "model/taylor2_with_noise.rs"]
mod model_taylor2_with_noise;
#[path = "model/too_many_coordinates.rs"]
mod model_too_many_coordinates;
#[path = "model/too_many_stages.rs"]
mod model_too_many_stages;
#[path = "model/vector_of_coordinates.rs"]
mod model_vector_of_coordinates;
#[path = "model/velocities_as_a_sum.rs"]
mod model_velocities_as_a_sum;
#[path = "model/velocity_cancels.rs"]
mod model_velocity_cancels;
#[path = "model/velocity_linear.rs"]
mod model_velocity_linear;
#[path = "model/velocity_missing.rs"]
mod model_velocity_missing;
#[path = "model/weak2_of_a_relativistic_particle.rs"]
mod model_weak2_of_a_relativistic_particle;
#[path = "model/weak2_of_noise_in_momentum.rs"]
mod model_weak2_of_noise_in_momentum;
#[path = "model/weak2_of_noises_that_do_not_commute.rs"]
mod model_weak2_of_noises_that_do_not_commute;
#[path = "model/weak2_with_cubic_friction.rs"]
mod model_weak2_with_cubic_friction;
#[path = "model/weak2_with_four_coupled_masses.rs"]
mod model_weak2_with_four_coupled_masses;
#[path = "model/weak2_without_noise.rs"]
mod model_weak2_without_noise;
#[path = "model/wrong_result.rs"]
mod model_wrong_result;
#[path = "noise/array_of_arrays.rs"]
mod noise_array_of_arrays;
#[path = "noise/constant_component.rs"]
mod noise_constant_component;
#[path = "noise/constant_h1.rs"]
mod noise_constant_h1;
#[path = "noise/constant_noise.rs"]
mod noise_constant_noise;
#[path = "noise/gamma_with_velocity.rs"]
mod noise_gamma_with_velocity;
#[path = "noise/h1_without_momentum.rs"]
mod noise_h1_without_momentum;
#[path = "noise/no_receiver.rs"]
mod noise_no_receiver;
#[path = "noise/no_result.rs"]
mod noise_no_result;
#[path = "noise/other_length.rs"]
mod noise_other_length;
#[path = "noise/rough.rs"]
mod noise_rough;
#[path = "noise/scalar_gamma_with_momentum.rs"]
mod noise_scalar_gamma_with_momentum;
#[path = "noise/wrong_result.rs"]
mod noise_wrong_result;
#[path = "parse/async_function.rs"]
mod parse_async_function;
#[path = "parse/comma_between_rules_missing.rs"]
mod parse_comma_between_rules_missing;
#[path = "parse/conditional_function.rs"]
mod parse_conditional_function;
#[path = "parse/doubled_rule.rs"]
mod parse_doubled_rule;
#[path = "parse/doubled_rule_with_an_option.rs"]
mod parse_doubled_rule_with_an_option;
#[path = "parse/drift_without_a_lagrangian.rs"]
mod parse_drift_without_a_lagrangian;
#[path = "parse/foreign_function.rs"]
mod parse_foreign_function;
#[path = "parse/four_arguments.rs"]
mod parse_four_arguments;
#[path = "parse/gauss_of_one_stage.rs"]
mod parse_gauss_of_one_stage;
#[path = "parse/gauss_of_sixteen_stages.rs"]
mod parse_gauss_of_sixteen_stages;
#[path = "parse/gauss_with_a_fraction.rs"]
mod parse_gauss_with_a_fraction;
#[path = "parse/gauss_with_two_numbers.rs"]
mod parse_gauss_with_two_numbers;
#[path = "parse/gauss_without_stages.rs"]
mod parse_gauss_without_stages;
#[path = "parse/generic_lagrangian.rs"]
mod parse_generic_lagrangian;
#[path = "parse/generic_length.rs"]
mod parse_generic_length;
#[path = "parse/generic_system.rs"]
mod parse_generic_system;
#[path = "parse/lagrangian_as_noise.rs"]
mod parse_lagrangian_as_noise;
#[path = "parse/misspelt_lagrangian.rs"]
mod parse_misspelt_lagrangian;
#[path = "parse/misspelt_role.rs"]
mod parse_misspelt_role;
#[path = "parse/momentum_before_position.rs"]
mod parse_momentum_before_position;
#[path = "parse/momentum_in_a_force.rs"]
mod parse_momentum_in_a_force;
#[path = "parse/momentum_in_a_lagrangian.rs"]
mod parse_momentum_in_a_lagrangian;
#[path = "parse/mutable_receiver.rs"]
mod parse_mutable_receiver;
#[path = "parse/named_lifetime.rs"]
mod parse_named_lifetime;
#[path = "parse/no_lagrangian.rs"]
mod parse_no_lagrangian;
#[path = "parse/no_receiver.rs"]
mod parse_no_receiver;
#[path = "parse/no_result.rs"]
mod parse_no_result;
#[path = "parse/one_argument.rs"]
mod parse_one_argument;
#[path = "parse/option_as_text.rs"]
mod parse_option_as_text;
#[path = "parse/option_misspelt.rs"]
mod parse_option_misspelt;
#[path = "parse/option_of_a_rule_without_options.rs"]
mod parse_option_of_a_rule_without_options;
#[path = "parse/option_of_other_rules.rs"]
mod parse_option_of_other_rules;
#[path = "parse/option_twice.rs"]
mod parse_option_twice;
#[path = "parse/option_unknown.rs"]
mod parse_option_unknown;
#[path = "parse/option_without_a_comma.rs"]
mod parse_option_without_a_comma;
#[path = "parse/path_of_the_runtime_as_text.rs"]
mod parse_path_of_the_runtime_as_text;
#[path = "parse/receiver_by_value.rs"]
mod parse_receiver_by_value;
#[path = "parse/role_by_another_name.rs"]
mod parse_role_by_another_name;
#[path = "parse/role_on_a_constant.rs"]
mod parse_role_on_a_constant;
#[path = "parse/role_with_arguments.rs"]
mod parse_role_with_arguments;
#[path = "parse/rule_as_text.rs"]
mod parse_rule_as_text;
#[path = "parse/rule_with_a_number.rs"]
mod parse_rule_with_a_number;
#[path = "parse/rule_with_empty_parentheses.rs"]
mod parse_rule_with_empty_parentheses;
#[path = "parse/scalars_in_another_order.rs"]
mod parse_scalars_in_another_order;
#[path = "parse/time_after_position.rs"]
mod parse_time_after_position;
#[path = "parse/time_in_a_symmetry.rs"]
mod parse_time_in_a_symmetry;
#[path = "parse/time_not_first.rs"]
mod parse_time_not_first;
#[path = "parse/two_lagrangians.rs"]
mod parse_two_lagrangians;
#[path = "parse/two_roles.rs"]
mod parse_two_roles;
#[path = "parse/unknown_argument.rs"]
mod parse_unknown_argument;
#[path = "parse/unknown_rule.rs"]
mod parse_unknown_rule;
#[path = "parse/unknown_rule_and_a_mistake_in_a_body.rs"]
mod parse_unknown_rule_and_a_mistake_in_a_body;
#[path = "parse/unsafe_function.rs"]
mod parse_unsafe_function;
#[path = "parse/velocity_before_position.rs"]
mod parse_velocity_before_position;
#[path = "rotation/by_reference.rs"]
mod rotation_by_reference;
#[path = "rotation/gamma_with_momentum.rs"]
mod rotation_gamma_with_momentum;
#[path = "rotation/h1_without_momentum.rs"]
mod rotation_h1_without_momentum;
#[path = "rotation/moment_of_inertia_missing.rs"]
mod rotation_moment_of_inertia_missing;
#[path = "rotation/momentum_of_a_vector.rs"]
mod rotation_momentum_of_a_vector;
#[path = "rotation/not_a_symmetry.rs"]
mod rotation_not_a_symmetry;
#[path = "rotation/one_coordinate.rs"]
mod rotation_one_coordinate;
#[path = "rotation/other_rules.rs"]
mod rotation_other_rules;
#[path = "rotation/part_missing.rs"]
mod rotation_part_missing;
#[path = "rotation/quaternion.rs"]
mod rotation_quaternion;
#[path = "rotation/reduced_with_a_gamma.rs"]
mod rotation_reduced_with_a_gamma;
#[path = "rotation/reduced_with_a_number.rs"]
mod rotation_reduced_with_a_number;
#[path = "rotation/reduced_with_a_rotation.rs"]
mod rotation_reduced_with_a_rotation;
#[path = "rotation/rotation_before_vector.rs"]
mod rotation_rotation_before_vector;
#[path = "rotation/rotation_in_the_plane.rs"]
mod rotation_rotation_in_the_plane;
#[path = "rotation/scaled_axis.rs"]
mod rotation_scaled_axis;
#[path = "rotation/single_precision.rs"]
mod rotation_single_precision;
#[path = "rotation/symmetry_as_a_rotation.rs"]
mod rotation_symmetry_as_a_rotation;
#[path = "rotation/torque_as_a_number.rs"]
mod rotation_torque_as_a_number;
#[path = "rotation/velocity_as_a_rotation.rs"]
mod rotation_velocity_as_a_rotation;
#[path = "rotation/velocity_before_rotation.rs"]
mod rotation_velocity_before_rotation;
#[path = "rotation/velocity_of_a_vector.rs"]
mod rotation_velocity_of_a_vector;
#[path = "rotation/weak2.rs"]
mod rotation_weak2;
#[path = "rotation/with_a_constraint.rs"]
mod rotation_with_a_constraint;
#[path = "symmetry/broken_by_little.rs"]
mod symmetry_broken_by_little;
#[path = "symmetry/broken_twice.rs"]
mod symmetry_broken_twice;
#[path = "symmetry/force_does_work.rs"]
mod symmetry_force_does_work;
#[path = "symmetry/mistake_in_its_body.rs"]
mod symmetry_mistake_in_its_body;
#[path = "symmetry/moves_nothing.rs"]
mod symmetry_moves_nothing;
#[path = "symmetry/not_of_a_gamma.rs"]
mod symmetry_not_of_a_gamma;
#[path = "symmetry/not_of_an_h1.rs"]
mod symmetry_not_of_an_h1;
#[path = "symmetry/not_of_the_lagrangian.rs"]
mod symmetry_not_of_the_lagrangian;
#[path = "symmetry/number_for_a_vector.rs"]
mod symmetry_number_for_a_vector;
#[path = "symmetry/other_length.rs"]
mod symmetry_other_length;
#[path = "symmetry/potential_breaks_the_shift.rs"]
mod symmetry_potential_breaks_the_shift;
#[path = "symmetry/steep_wall.rs"]
mod symmetry_steep_wall;
#[path = "symmetry/with_velocity.rs"]
mod symmetry_with_velocity;
#[path = "symmetry/wrong_sign.rs"]
mod symmetry_wrong_sign;

fn main() {}
