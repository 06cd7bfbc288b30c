/// @file
/// Forward automatic differentiation of the models, for the Taylor linearization.
///
/// Every operation is carried out at once. Eigen's AutoDiffScalar, which puts whole formulas into one
/// expression, is as fast, but a model costs the compiler several times as long and as much memory.
#pragma once

#include <Eigen/Core>
#include <cmath>

namespace leadline {

/// Entries that a function to be linearized may read, its noises included.
inline constexpr int kMaxInputs = 12;

/// A number with its derivatives by up to kMaxInputs others. One type serves functions of any number of
/// inputs, so that a model is compiled once for it, whoever reads it.
class Dual {
 public:
  using Derivatives = Eigen::Matrix<double, kMaxInputs, 1>;

  Dual(double value = 0.0) : value_(value), derivatives_(Derivatives::Zero()) {}  // NOLINT: as a double
  Dual(double value, const Derivatives& derivatives) : value_(value), derivatives_(derivatives) {}

  /// The input of that number.
  static Dual input(double value, int index) { return {value, Derivatives::Unit(index)}; }

  double value() const { return value_; }
  const Derivatives& derivatives() const { return derivatives_; }

  Dual operator-() const { return {-value_, -derivatives_}; }
  Dual& operator+=(const Dual& b) { return *this = *this + b; }
  Dual& operator-=(const Dual& b) { return *this = *this - b; }
  Dual& operator*=(const Dual& b) { return *this = *this * b; }
  Dual& operator/=(const Dual& b) { return *this = *this / b; }

  friend Dual operator+(const Dual& a, const Dual& b) {
    return {a.value_ + b.value_, a.derivatives_ + b.derivatives_};
  }
  friend Dual operator-(const Dual& a, const Dual& b) {
    return {a.value_ - b.value_, a.derivatives_ - b.derivatives_};
  }
  friend Dual operator*(const Dual& a, const Dual& b) {
    return {a.value_ * b.value_, a.derivatives_ * b.value_ + b.derivatives_ * a.value_};
  }
  friend Dual operator/(const Dual& a, const Dual& b) {
    return {a.value_ / b.value_,
            (a.derivatives_ * b.value_ - b.derivatives_ * a.value_) / (b.value_ * b.value_)};
  }
  friend Dual operator+(const Dual& a, double b) { return {a.value_ + b, a.derivatives_}; }
  friend Dual operator+(double a, const Dual& b) { return b + a; }
  friend Dual operator-(const Dual& a, double b) { return {a.value_ - b, a.derivatives_}; }
  friend Dual operator-(double a, const Dual& b) { return {a - b.value_, -b.derivatives_}; }
  friend Dual operator*(const Dual& a, double b) { return {a.value_ * b, a.derivatives_ * b}; }
  friend Dual operator*(double a, const Dual& b) { return b * a; }
  friend Dual operator/(const Dual& a, double b) { return {a.value_ / b, a.derivatives_ / b}; }

  friend bool operator<(const Dual& a, const Dual& b) { return a.value_ < b.value_; }
  friend bool operator>(const Dual& a, const Dual& b) { return a.value_ > b.value_; }

  friend Dual sin(const Dual& a) { return {std::sin(a.value_), a.derivatives_ * std::cos(a.value_)}; }
  friend Dual cos(const Dual& a) { return {std::cos(a.value_), a.derivatives_ * -std::sin(a.value_)}; }
  friend Dual tan(const Dual& a) {
    const double tangent = std::tan(a.value_);
    return {tangent, a.derivatives_ * (1.0 + tangent * tangent)};
  }
  friend Dual sqrt(const Dual& a) {
    const double root = std::sqrt(a.value_);
    return {root, a.derivatives_ * (0.5 / root)};
  }
  friend Dual atan2(const Dual& y, const Dual& x) {
    const double squared = x.value_ * x.value_ + y.value_ * y.value_;
    return {std::atan2(y.value_, x.value_),
            (y.derivatives_ * x.value_ - x.derivatives_ * y.value_) / squared};
  }

 private:
  double value_;
  Derivatives derivatives_;
};

}  // namespace leadline

/// @cond
template <>
struct Eigen::NumTraits<leadline::Dual> : Eigen::NumTraits<double> {
  using Real = leadline::Dual;
  using NonInteger = leadline::Dual;
  using Nested = leadline::Dual;
  enum { RequireInitialization = 1 };  // NOLINT(readability-identifier-naming): Eigen's name
};
/// @endcond
