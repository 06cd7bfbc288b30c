#include "leadline/core/chi_square.h"

#include <boost/math/distributions/chi_squared.hpp>

namespace leadline {

double chi_square_quantile(double probability, double dof) {
  return boost::math::quantile(boost::math::chi_squared(dof), probability);
}

double chi_square_probability(double value, double dof) {
  return boost::math::cdf(boost::math::chi_squared(dof), value);
}

}  // namespace leadline
