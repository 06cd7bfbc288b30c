/// @file
/// Checks of options. What is not finite fails them all.
#pragma once

#include <cmath>
#include <sstream>
#include <stdexcept>
#include <string>

namespace leadline {

/// Limits of a sensor's rate [Hz].
inline constexpr double kMinRate = 0.001;
inline constexpr double kMaxRate = 1000.0;

/// Checks options that are members of one struct.
class Check {
 public:
  /// Of the options themselves, and of the member at @p path in them, as "sonars[1]".
  Check() = default;
  explicit Check(const std::string& path) : prefix_(path + '.') {}

  /// @throws std::invalid_argument "path.name is value, must be allowed" unless @p ok.
  template <class T>
  void that(bool ok, const char* name, T value, const std::string& allowed) const {
    if (ok) return;
    std::ostringstream message;
    message.precision(12);
    message << prefix_ << name << " is " << value << ", must be " << allowed;
    throw std::invalid_argument(message.str());
  }

  void finite(const char* name, double value) const { that(std::isfinite(value), name, value, "finite"); }
  void positive(const char* name, double value) const {
    that(std::isfinite(value) && value > 0.0, name, value, "finite and greater than 0");
  }
  void not_negative(const char* name, double value) const {
    that(std::isfinite(value) && value >= 0.0, name, value, "finite and at least 0");
  }
  template <class T>
  void between(const char* name, T value, T low, T high) const {
    if (value >= low && value <= high) return;
    std::ostringstream allowed;
    allowed.precision(12);
    allowed << "from " << low << " to " << high;
    that(false, name, value, allowed.str());
  }
  void rate_or_none(const char* name, double value) const {
    that(value == 0.0 || (value >= kMinRate && value <= kMaxRate), name, value, "0 or from 0.001 to 1000");
  }
  void probability(const char* name, double value) const { between(name, value, 0.0, 1.0); }

 private:
  std::string prefix_;
};

}  // namespace leadline
