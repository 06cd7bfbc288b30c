/// @file
/// Documents keys: the reference page of the configuration.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "leadline/core/options.h"

namespace leadline::app {

/// A Markdown table for every section, in the order of the declarations.
class KeyReference final : public OptionVisitor {
 public:
  KeyReference();

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
  void defaults(const std::function<void()>& assign, std::span<const DefaultText> texts) override;
  void require(bool, std::string_view, std::string_view) override {}

  std::string take() &&;

 private:
  struct Row {
    std::string name, unit, default_value, allowed, meaning;
    std::string condition = {};                  // under which the key is this one
    std::vector<std::string> alternatives = {};  // that have the key; none: all
  };
  struct Part {
    std::string path, condition, heading;
    std::vector<Row> rows = {};
  };

  void row(std::string_view name, std::string_view default_value, std::string_view allowed,
           const OptionText& text);
  std::string shown_default(std::string_view name, std::string_view value) const;
  void enter(const std::string& name, std::string_view meaning, const std::function<void()>& body);

  std::vector<Part> parts_;  // in the order of their headings
  std::size_t part_ = 0;     // being written
  std::string path_;         // of the section being written, with the last dot
  std::string condition_;
  std::string alternative_;
  std::vector<std::pair<std::string, std::string>> default_texts_;  // by the whole name
};

}  // namespace leadline::app
