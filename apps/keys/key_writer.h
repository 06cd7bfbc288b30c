/// @file
/// Writes the values of keys as JSON, which is also YAML that reads back to the same values.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <utility>

#include "leadline/core/options.h"

namespace leadline::app {

class KeyWriter final : public OptionVisitor {
 public:
  void number(std::string_view name, double& value, Limits allowed, const OptionText& text) override;
  void whole_number(std::string_view name, std::int64_t& value, Limits allowed,
                    const OptionText& text) override;
  void flag(std::string_view name, bool& value, const OptionText& text) override;
  void word(std::string_view name, std::string& value, Limits allowed, const OptionText& text) override;
  void one_of(std::string_view name, std::size_t& index, std::span<const std::string_view> options,
              const OptionText& text) override;
  void section(std::string_view name, std::string_view meaning, const std::function<void()>& body) override;
  void sections(std::string_view name, std::string_view meaning, std::size_t size,
                const std::function<void(std::size_t)>& resize,
                const std::function<void(std::size_t)>& body) override;
  void only(std::string_view condition, bool holds, const std::function<void()>& body) override;
  void alternative(std::string_view name, bool in_use, const std::function<void()>& body) override;
  void defaults(const std::function<void()>&, std::span<const DefaultText>) override {}
  void require(bool, std::string_view, std::string_view) override {}

  nlohmann::ordered_json take() && { return std::move(json_); }

 private:
  nlohmann::ordered_json json_ = nlohmann::ordered_json::object();  // of the section being written
};

}  // namespace leadline::app
