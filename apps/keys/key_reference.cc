#include "apps/keys/key_reference.h"

#include <fmt/format.h>

#include <iterator>

#include "apps/keys/units.h"

namespace leadline::app {

KeyReference::KeyReference() {
  parts_.push_back(
      {"# Configuration\n\n"
       "One YAML file describes a run. Every key has a default; an unknown or doubled key, a wrong type and "
       "a value\n"
       "out of range are errors. `--set key.path=value` on the command line overrides the file and passes "
       "the same\n"
       "checks; elements of lists are counted from 0: `--set sensors.0.range_sigma_m=0.1`. Sigmas are "
       "standard\n"
       "deviations; those per sqrt(s) are random walks, which grow with the square root of time.\n\n"
       "This page is printed by `leadline reference`.\n\n"});
}

void KeyReference::number(std::string_view name, double& value, Limits allowed, const KeyText& text) {
  row(name, in_unit(value, text.unit), fmt::format("{} to {}", allowed.min, allowed.max), text);
}

void KeyReference::whole_number(std::string_view name, std::int64_t& value, Limits allowed,
                                const KeyText& text) {
  row(name, std::to_string(value),
      fmt::format("{} to {}", static_cast<std::int64_t>(allowed.min), static_cast<std::int64_t>(allowed.max)),
      text);
}

void KeyReference::flag(std::string_view name, bool& value, const KeyText& text) {
  row(name, value ? "true" : "false", "true, false", text);
}

void KeyReference::word(std::string_view name, std::string& value, Limits allowed, const KeyText& text) {
  row(name, value, fmt::format("{} to {} bytes", allowed.min, allowed.max), text);
}

void KeyReference::one_of(std::string_view name, std::size_t& index,
                          std::span<const std::string_view> options, const KeyText& text) {
  row(name, options[index], fmt::format("{}", fmt::join(options, ", ")), text);
}

void KeyReference::section(std::string_view name, std::string_view meaning,
                           const std::function<void()>& body) {
  enter(std::string(name), meaning, body);
}

void KeyReference::sections(std::string_view name, std::string_view meaning, std::size_t,
                            const std::function<void(std::size_t)>&,
                            const std::function<void(std::size_t)>& body) {
  enter(std::string(name) + ".N", meaning, [&] { body(0); });
}

void KeyReference::only(std::string_view condition, bool, const std::function<void()>& body) {
  condition_ = condition;
  body();
  condition_.clear();
}

std::string KeyReference::take() && {
  std::string page;
  for (const Part& part : parts_) {
    page += part.heading;
    if (part.rows.empty()) continue;
    page += "| key | unit | default | allowed | meaning |\n|---|---|---|---|---|\n" + part.rows + "\n";
  }
  page.pop_back();
  return page;
}

void KeyReference::row(std::string_view name, std::string_view default_value, std::string_view allowed,
                       const KeyText& text) {
  const std::string_view shown = text.fallback.empty() ? default_value : text.fallback;
  const bool top_of_condition = !condition_.empty() && path_.find('.') == path_.size() - 1;
  fmt::format_to(std::back_inserter(parts_[part_].rows), "| `{}` | {} | {} | {} | {}{} |\n", name, text.unit,
                 shown, allowed, top_of_condition ? fmt::format("({}) ", condition_) : "", text.meaning);
}

void KeyReference::enter(const std::string& name, std::string_view meaning,
                         const std::function<void()>& body) {
  const std::size_t outer_part = std::exchange(part_, parts_.size());
  const std::string outer_path = std::exchange(path_, path_ + name + ".");
  parts_.push_back({fmt::format("## {}\n\n{}{}\n\n", path_.substr(0, path_.size() - 1), meaning,
                                condition_.empty() ? "" : fmt::format(" Only with `{}`.", condition_))});
  body();
  part_ = outer_part;
  path_ = outer_path;
}

}  // namespace leadline::app
