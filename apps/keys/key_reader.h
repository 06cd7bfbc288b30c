/// @file
/// Reads the values of keys from YAML, and refuses what is not as declared.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "apps/keys/yaml_tree.h"
#include "leadline/core/options.h"

namespace leadline::app {

/// Every fault is reported with the place of the value, its key, the value and what is allowed, as
/// YamlPlace::fail() does.
class KeyReader final : public OptionVisitor {
 public:
  explicit KeyReader(const YamlTree& root);

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
  void require(bool holds, std::string_view name, std::string_view allowed) override;
  void gone(std::string_view name, std::string_view why) override;

  /// Refuses keys at the top that nobody asked for. (Those of a section at the top, and of all inside it, are
  /// refused at its end.)
  void finish() const { refuse_unknown(levels_.front()); }

 private:
  struct Known {
    std::string name;
    std::string value;      // in words, for require()
    std::string condition;  // under which alone the key means something; empty: it does
  };
  // A section that is being read.
  struct Level {
    const YamlTree* node = nullptr;  // null: not in the file
    std::string path;                // of its keys, with the last dot
    YamlPlace place;
    std::vector<Known> known = {};
    std::vector<std::pair<std::string, std::string>> gone = {};  // name, why
    std::vector<Level> inner = {};  // sections that were read, of which another part may follow
  };

  const YamlTree* find(std::string_view name, std::string default_value);
  const YamlTree* find_scalar(std::string_view name, std::string default_value, std::string_view allowed);
  void enter(std::string_view name, const YamlTree* node, const std::function<void()>& body);
  Level open(std::string path, const YamlTree* node);
  static void refuse_unknown(const Level& level);
  [[noreturn]] void refuse(const YamlTree& value, std::string_view name, std::string_view allowed) const;

  std::vector<Level> levels_;
  std::string condition_;  // that does not hold
};

}  // namespace leadline::app
