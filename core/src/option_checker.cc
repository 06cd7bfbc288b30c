#include "leadline/core/option_checker.h"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <stdexcept>

namespace leadline {

namespace {

/// 15 digits: what was 20 degrees before it became radians is 20 again.
std::string as_text(double value) {
  std::ostringstream text;
  text.precision(15);
  text << value;
  return text.str();
}

std::string between(Limits allowed) { return "from " + as_text(allowed.min) + " to " + as_text(allowed.max); }

std::string list(std::span<const std::string_view> choices) {
  std::string text;
  for (const std::string_view choice : choices) {
    if (!text.empty()) text += ", ";
    text += choice;
  }
  return text;
}

}  // namespace

void refuse_option(std::string_view name, std::string_view value, std::string_view allowed) {
  throw std::invalid_argument(std::string(name) + " is " + std::string(value) + ", must be " +
                              std::string(allowed));
}

void OptionChecker::number(std::string_view name, double& value, Limits allowed, const OptionText& text) {
  // Compared in SI, as it will be used. The way to radians and back is not exact.
  const bool angle = text.unit.starts_with("deg");
  const double min = from_unit(allowed.min, text.unit), max = from_unit(allowed.max, text.unit);
  const double rounding = angle ? 1e-14 : 0.0;
  const Limits si{min - rounding * std::abs(min), max + rounding * std::abs(max)};
  check(si.contain(value), name, as_text(angle ? to_degrees(value) : value), between(allowed));
}

void OptionChecker::whole_number(std::string_view name, std::int64_t& value, Limits allowed,
                                 const OptionText&) {
  check(allowed.contain(static_cast<double>(value)), name, std::to_string(value), between(allowed));
}

void OptionChecker::flag(std::string_view name, bool& value, const OptionText&) {
  check(true, name, value ? "true" : "false", {});
}

void OptionChecker::word(std::string_view name, std::string& value, Limits allowed, const OptionText&) {
  check(allowed.contain(static_cast<double>(value.size())), name, '"' + value + '"',
        "a text of " + as_text(allowed.min) + " to " + as_text(allowed.max) + " bytes");
}

void OptionChecker::one_of(std::string_view name, std::size_t& index,
                           std::span<const std::string_view> choices, const OptionText&) {
  const bool known = index < choices.size();
  check(known, name, known ? std::string(choices[index]) : "no value of its type", "one of " + list(choices));
}

void OptionChecker::section(std::string_view name, std::string_view, const std::function<void()>& body) {
  enter(name, body);
}

void OptionChecker::sections(std::string_view name, std::string_view, std::size_t size,
                             const std::function<void(std::size_t)>&,
                             const std::function<void(std::size_t)>& body) {
  check(true, name, size == 0 ? "an empty list" : "a list", {});
  for (std::size_t i = 0; i < size; ++i) enter(std::string(name) + '.' + std::to_string(i), [&] { body(i); });
}

void OptionChecker::only(std::string_view, bool holds, const std::function<void()>& body) {
  if (holds) body();
}

void OptionChecker::alternative(std::string_view, bool in_use, const std::function<void()>& body) {
  if (in_use) body();
}

void OptionChecker::require(bool holds, std::string_view name, std::string_view allowed) {
  if (holds) return;
  const std::string whole = path_ + std::string(name);
  const auto visited = std::ranges::find(values_, whole, &std::pair<std::string, std::string>::first);
  refuse_option(whole, visited == values_.end() ? "not given" : visited->second, allowed);
}

void OptionChecker::check(bool holds, std::string_view name, std::string value, std::string_view allowed) {
  std::string whole = path_ + std::string(name);
  if (!holds) refuse_option(whole, value, allowed);
  values_.emplace_back(std::move(whole), std::move(value));
}

void OptionChecker::enter(std::string_view name, const std::function<void()>& body) {
  const std::size_t outer = path_.size();
  path_ += name;
  path_ += '.';
  body();
  path_.resize(outer);
}

}  // namespace leadline
