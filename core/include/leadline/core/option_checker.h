/// @file
/// Refuses options that are not as declared.
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "leadline/core/options.h"

namespace leadline {

/// @throws std::invalid_argument "name is value, must be allowed".
[[noreturn]] void refuse_option(std::string_view name, std::string_view value, std::string_view allowed);

/// Changes nothing. Every member throws as refuse_option() does on what is not as declared, with the whole
/// name and the value in the unit of the declaration: "vehicle.noise.sway_sigma_m is -1, must be from 0 to
/// 1000". What is not finite is never allowed. Angles may be beyond a limit by rounding.
class OptionChecker final : public OptionVisitor {
 public:
  void number(std::string_view name, double& value, Limits allowed, const OptionText& text) override;
  void whole_number(std::string_view name, std::int64_t& value, Limits allowed,
                    const OptionText& text) override;
  void flag(std::string_view name, bool& value, const OptionText& text) override;
  void word(std::string_view name, std::string& value, Limits allowed, const OptionText& text) override;
  void one_of(std::string_view name, std::size_t& index, std::span<const std::string_view> choices,
              const OptionText& text) override;
  void section(std::string_view name, std::string_view meaning, const std::function<void()>& body) override;
  void sections(std::string_view name, std::string_view meaning, std::size_t size,
                const std::function<void(std::size_t)>& resize,
                const std::function<void(std::size_t)>& body) override;
  void only(std::string_view condition, bool holds, const std::function<void()>& body) override;
  void alternative(std::string_view name, bool in_use, const std::function<void()>& body) override;
  void defaults(const std::function<void()>&, std::span<const DefaultText>) override {}
  void require(bool holds, std::string_view name, std::string_view allowed) override;

 private:
  void check(bool holds, std::string_view name, std::string value, std::string_view allowed);
  void enter(std::string_view name, const std::function<void()>& body);

  std::string path_;                                         // of the section, with the last dot
  std::vector<std::pair<std::string, std::string>> values_;  // of what was visited, for require()
};

}  // namespace leadline
