/// @file
/// Chi-square quantiles and probabilities (Boost.Math).
#pragma once

namespace leadline {

/// Value below which a chi-square variable of @p dof degrees of freedom stays with @p probability in (0, 1).
double chi_square_quantile(double probability, double dof);

/// Probability that a chi-square variable of @p dof degrees of freedom stays below @p value.
double chi_square_probability(double value, double dof);

}  // namespace leadline
