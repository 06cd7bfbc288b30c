/// @file
/// The keys of the configuration, declared once: name, unit, default, limits and meaning. Whoever reads,
/// writes or documents a configuration visits the same declarations.
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

#include "apps/support/limits.h"

namespace leadline::app {

/// What a key says beside its value.
struct KeyText {
  std::string_view unit;           ///< of the value in the file; what begins with "deg" is held in radians
  std::string_view meaning;        ///< one line
  std::string_view fallback = {};  ///< the default in words, where it depends on other keys
};

/// Visits the keys of a configuration. Each member is called with the variable that holds the key's value;
/// what it holds before is the default.
class Keys {
 public:
  virtual ~Keys() = default;

  /// @param allowed in the unit of the file. Always finite.
  virtual void number(std::string_view name, double& value, Limits allowed, const KeyText& text) = 0;
  virtual void whole_number(std::string_view name, std::int64_t& value, Limits allowed,
                            const KeyText& text) = 0;
  virtual void flag(std::string_view name, bool& value, const KeyText& text) = 0;
  /// @param allowed number of bytes.
  virtual void word(std::string_view name, std::string& value, Limits allowed, const KeyText& text) = 0;
  virtual void one_of(std::string_view name, std::size_t& index, std::span<const std::string_view> options,
                      const KeyText& text) = 0;

  /// Keys inside another; @p body visits them.
  virtual void section(std::string_view name, std::string_view meaning,
                       const std::function<void()>& body) = 0;

  /// A list of sections. @param resize makes so many elements, all with defaults; @param body visits the
  /// keys of one.
  virtual void sections(std::string_view name, std::string_view meaning, std::size_t size,
                        const std::function<void(std::size_t)>& resize,
                        const std::function<void(std::size_t)>& body) = 0;

  /// Keys that have a meaning only if @p condition, which is so in this configuration or not.
  virtual void only(std::string_view condition, bool holds, const std::function<void()>& body) = 0;

  /// Defaults that depend on keys visited before: @p assign puts them into the variables.
  virtual void defaults(const std::function<void()>& assign) = 0;

  /// A condition between keys. @param name the key of this section to blame. @param allowed what it must be.
  virtual void require(bool holds, std::string_view name, std::string_view allowed) = 0;

  void integer(std::string_view name, int& value, Limits allowed, const KeyText& text) {
    std::int64_t wide = value;
    whole_number(name, wide, allowed, text);
    value = static_cast<int>(wide);
  }

  template <class E>
  using Options = std::initializer_list<std::pair<std::string_view, E>>;

  template <class E>
  void choice(std::string_view name, E& value, Options<E> options, const KeyText& text) {
    std::vector<std::string_view> names;
    std::size_t index = 0;
    for (const auto& [option, meant] : options) {
      if (meant == value) index = names.size();
      names.push_back(option);
    }
    one_of(name, index, names, text);
    value = (options.begin() + index)->second;
  }
};

}  // namespace leadline::app
