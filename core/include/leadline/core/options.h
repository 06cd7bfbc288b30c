/// @file
/// Options are declared once, beside the struct that holds them: name, unit, limits and meaning. Whoever
/// checks, reads, writes or documents them visits the same declarations.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <initializer_list>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "leadline/core/angle.h"

namespace leadline {

/// Closed interval; what is not a number lies in none.
struct Limits {
  double min = 0.0;
  double max = 0.0;

  constexpr bool contain(double value) const { return value >= min && value <= max; }
};

/// What an option says beside its value.
struct OptionText {
  std::string_view unit;     ///< of its limits and in files; what begins with "deg" is held in radians
  std::string_view meaning;  ///< one line
};

/// SI value of @p value in @p unit: what begins with "deg" becomes radians, all else is SI.
constexpr double from_unit(double value, std::string_view unit) {
  return unit.starts_with("deg") ? from_degrees(value) : value;
}

/// Where a default comes from, in words.
struct DefaultText {
  std::string_view option;  ///< as seen from the section in use: "noise.increment_sigma_m"
  std::string_view words;   ///< "as believed"
};

/// Visits options. Each member is called with the variable that holds the option's value; what it holds
/// before is the default.
class OptionVisitor {
 public:
  virtual ~OptionVisitor() = default;

  /// @param allowed in the unit of @p text. Always finite.
  virtual void number(std::string_view name, double& value, Limits allowed, const OptionText& text) = 0;
  virtual void whole_number(std::string_view name, std::int64_t& value, Limits allowed,
                            const OptionText& text) = 0;
  virtual void flag(std::string_view name, bool& value, const OptionText& text) = 0;
  /// @param allowed number of bytes.
  virtual void word(std::string_view name, std::string& value, Limits allowed, const OptionText& text) = 0;
  /// @param index of the choice; as many as there are where the value is none of them, which only a visitor
  /// that checks may be called with.
  virtual void one_of(std::string_view name, std::size_t& index, std::span<const std::string_view> choices,
                      const OptionText& text) = 0;

  /// Options inside another; @p body visits them. A section may be visited in parts, of which the first says
  /// what it means.
  virtual void section(std::string_view name, std::string_view meaning,
                       const std::function<void()>& body) = 0;

  /// A list of sections. @param resize makes so many elements, all with defaults; @param body visits the
  /// options of one.
  virtual void sections(std::string_view name, std::string_view meaning, std::size_t size,
                        const std::function<void(std::size_t)>& resize,
                        const std::function<void(std::size_t)>& body) = 0;

  /// Options that have a meaning only if @p condition, which is so here or not.
  virtual void only(std::string_view condition, bool holds, const std::function<void()>& body) = 0;

  /// Options of one of several things of which one is in use. They may be given whichever that is: of one
  /// that is not in use, @p body visits defaults, and what they become is forgotten.
  virtual void alternative(std::string_view name, bool in_use, const std::function<void()>& body) = 0;

  /// Defaults that depend on options visited before: @p assign puts them into the variables.
  virtual void defaults(const std::function<void()>& assign, std::span<const DefaultText> texts) = 0;

  /// A condition between options. @param name the option of this section to blame, visited before.
  /// @param allowed what it must be.
  virtual void require(bool holds, std::string_view name, std::string_view allowed) = 0;

  /// An option of earlier versions. Who is given one refuses it. @param why it is gone.
  virtual void gone([[maybe_unused]] std::string_view name, [[maybe_unused]] std::string_view why) {}

  void integer(std::string_view name, int& value, Limits allowed, const OptionText& text) {
    std::int64_t wide = value;
    whole_number(name, wide, allowed, text);
    value = static_cast<int>(wide);
  }

  template <class E>
  using Choices = std::initializer_list<std::pair<std::string_view, E>>;

  template <class E>
  void choice(std::string_view name, E& value, Choices<E> choices, const OptionText& text) {
    std::vector<std::string_view> names;
    std::size_t index = choices.size();
    for (const auto& [choice, meant] : choices) {
      if (meant == value) index = names.size();
      names.push_back(choice);
    }
    one_of(name, index, names, text);
    value = (choices.begin() + index)->second;
  }
};

}  // namespace leadline
